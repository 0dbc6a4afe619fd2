//! A CSV table that grows row by row, in a program that may be killed at any moment. Each row is written at once, and a
//! run that resumes cuts the table after the last row that its checkpoint knows of.

use super::{io_error, publish};
use crate::error::Error;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::fs::{File, OpenOptions};
use std::io::{ErrorKind, Write};
use std::marker::PhantomData;
use std::path::{Path, PathBuf};
use volmap_formats::text::thousands;

/// A growing table of rows of one kind. The first column is a number that never decreases.
pub struct Table<Row> {
    path: PathBuf,
    file: File,
    rows: PhantomData<Row>,
    repair: Repair,
}

/// Which rows a table that continues keeps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Kept {
    /// Number of the first row that there should be.
    pub first: u64,
    /// Number of the last row that is kept.
    pub last: u64,
    /// Whether several rows may have one number.
    pub several: bool,
}

/// What a table that continues has lost.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Repair {
    /// Whole rows after the last that is kept. What they tell of is computed again.
    pub cut: u64,
    /// Rows that are torn, out of order or there twice, as after two runs in one folder.
    pub damaged: u64,
    /// Numbers without a row, first and last of each gap.
    pub gaps: Vec<[u64; 2]>,
}

impl<Row: Serialize + DeserializeOwned> Table<Row> {
    /// A table without rows, in place of an older one. The `sample` gives the names of the columns.
    ///
    /// # Errors
    /// A file that can't be made.
    pub fn create(path: &Path, sample: &Row) -> Result<Table<Row>, Error> {
        let mut file = File::create(path).map_err(io_error(path))?;
        file.write_all(&header(sample)).map_err(io_error(path))?;
        Ok(Table { path: path.to_owned(), file, rows: PhantomData, repair: Repair::default() })
    }

    /// A table that continues: rows whose first column is above `kept.last` are removed, as are those that are damaged.
    /// A missing table is created. [`Table::repair`] tells what was lost.
    ///
    /// # Errors
    /// A file that can't be read or written, or that has other columns.
    pub fn resume(path: &Path, sample: &Row, kept: Kept) -> Result<Table<Row>, Error> {
        let bytes = match std::fs::read(path) {
            Ok(bytes) => bytes,
            Err(error) if error.kind() == ErrorKind::NotFound => Vec::new(),
            Err(error) => return Err(io_error(path)(error)),
        };
        let header = header(sample);
        if !bytes.starts_with(&header) && !header.starts_with(&bytes) {
            let reason =
                "has other columns, so it can't be continued; move it away, or simulate into another folder";
            return Err(io_error(path)(std::io::Error::new(ErrorKind::InvalidData, reason)));
        }
        // The program may have been killed before the header was complete.
        let whole = if bytes.len() < header.len() { &header } else { &bytes };
        let Sorted { kept, repair } = sort::<Row>(whole, kept);
        if kept.len() < bytes.len() && bytes.starts_with(&kept) {
            let cut =
                OpenOptions::new().write(true).open(path).and_then(|file| file.set_len(kept.len() as u64));
            cut.map_err(io_error(path))?;
        } else if kept != bytes {
            publish(path, &kept)?;
        }
        let file = OpenOptions::new().append(true).open(path).map_err(io_error(path))?;
        Ok(Table { path: path.to_owned(), file, rows: PhantomData, repair })
    }

    /// What was lost when it was continued.
    pub fn repair(&self) -> &Repair {
        &self.repair
    }

    /// Adds rows. They are in the file when this returns.
    ///
    /// # Errors
    /// A file that can't be written.
    pub fn append(&mut self, rows: &[Row]) -> Result<(), Error> {
        self.file.write_all(&to_csv(rows, false)).map_err(io_error(&self.path))
    }

    /// All rows of the file.
    ///
    /// # Errors
    /// A file that can't be read, or is damaged.
    pub fn rows(&self) -> Result<Vec<Row>, Error> {
        let bytes = std::fs::read(&self.path).map_err(io_error(&self.path))?;
        let rows = csv::Reader::from_reader(&bytes[..]).into_deserialize().collect::<Result<_, csv::Error>>();
        rows.map_err(|error| io_error(&self.path)(std::io::Error::new(ErrorKind::InvalidData, error)))
    }
}

impl Repair {
    /// What was removed and what is missing, in words; none if the table was cut nowhere. `what` the numbers count, as
    /// `step`.
    pub fn note(&self, file: &str, what: &str) -> Option<String> {
        let rows = |n: u64| if n == 1 { "1 row".to_owned() } else { format!("{} rows", thousands(n)) };
        let mut parts = Vec::new();
        if self.cut > 0 {
            parts.push(format!("{} after the checkpoint removed, to be computed again", rows(self.cut)));
        }
        if self.damaged > 0 {
            parts.push(format!("{} removed that are damaged or there twice", rows(self.damaged)));
        }
        if !self.gaps.is_empty() {
            let gap = |&[first, last]: &[u64; 2]| match first == last {
                true => thousands(first),
                false => format!("{} to {}", thousands(first), thousands(last)),
            };
            let told: Vec<String> = self.gaps.iter().take(MOST_GAPS).map(gap).collect();
            let more = if self.gaps.len() > MOST_GAPS { " and others" } else { "" };
            parts.push(format!("no row of {what} {}{more}", told.join(", ")));
        }
        (!parts.is_empty()).then(|| format!("{file}: {}", parts.join("; ")))
    }
}

/// Gaps that a note names.
const MOST_GAPS: usize = 3;

fn header<Row: Serialize>(sample: &Row) -> Vec<u8> {
    let both = to_csv(&[sample], true);
    both.split_inclusive(|&byte| byte == b'\n').next().unwrap_or_default().to_vec()
}

fn to_csv<Row: Serialize>(rows: &[Row], with_header: bool) -> Vec<u8> {
    let mut writer = csv::WriterBuilder::new().has_headers(with_header).from_writer(Vec::new());
    rows.iter().for_each(|row| writer.serialize(row).expect("rows are flat, and memory takes all"));
    writer.into_inner().expect("memory takes all")
}

/// A table's bytes that stay, and what doesn't.
struct Sorted {
    kept: Vec<u8>,
    repair: Repair,
}

/// The first column.
fn number(record: &csv::ByteRecord) -> Option<u64> {
    std::str::from_utf8(record.get(0)?).ok()?.parse().ok()
}

/// The header and the rows that stay. A torn row costs no other one.
fn sort<Row: DeserializeOwned>(bytes: &[u8], Kept { first, last, several }: Kept) -> Sorted {
    let mut reader = csv::ReaderBuilder::new().flexible(true).from_reader(bytes);
    let columns = reader.byte_headers().cloned().unwrap_or_default();
    let mut end = reader.position().byte() as usize;
    let mut out = Sorted { kept: bytes[..end].to_vec(), repair: Repair::default() };
    let mut record = csv::ByteRecord::new();
    let (mut next, mut same) = (first, Vec::<&[u8]>::new());
    while let Ok(true) = reader.read_byte_record(&mut record) {
        let row = &bytes[std::mem::replace(&mut end, reader.position().byte() as usize)..end];
        let number = match number(&record) {
            Some(number) if record.len() == columns.len() && row.ends_with(b"\n") => number,
            // The last one: the program was killed while it wrote.
            _ if end == bytes.len() => continue,
            _ => {
                out.repair.damaged += 1;
                continue;
            }
        };
        let goes_on = several && number + 1 == next && !same.is_empty() && !same.contains(&row);
        if record.deserialize::<Row>(Some(&columns)).is_err() || (number < next && !goes_on) {
            out.repair.damaged += 1;
        } else if number > last {
            out.repair.cut += 1;
        } else {
            if number > next {
                out.repair.gaps.push([next, number - 1]);
            }
            if number >= next {
                same.clear();
            }
            same.push(row);
            next = number + 1;
            out.kept.extend(row);
        }
    }
    if next <= last {
        out.repair.gaps.push([next, last]);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde::Deserialize;

    #[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
    struct Row {
        step: u64,
        name: String,
        x: f64,
    }

    fn row(step: u64) -> Row {
        Row { step, name: format!("a, \"b\"\n{step}"), x: step as f64 / 3.0 }
    }

    const UP_TO_3: Kept = Kept { first: 1, last: 3, several: true };

    /// What a folder holds into which two programs wrote: rows twice, torn into each other, zeros of a cut file.
    #[test]
    fn torn_rows_are_told_and_cost_no_others() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("table.csv");
        let head = "step,name,x\n";
        let text = format!(
            "{head}1,a,0.5\n1,a,0.6\n2,b,0.5\n3,c,0.53,c,0.5\n4,d,x\n\0\0\x005,e,1\n6,f,1\n5,e,1\n7,g,1\n8,h,1\n9,"
        );
        std::fs::write(&path, text).unwrap();
        let kept = Kept { first: 1, last: 7, several: false };
        let mut table = Table::resume(&path, &Row::default(), kept).unwrap();
        let repair = Repair { cut: 1, damaged: 5, gaps: vec![[3, 5]] };
        assert_eq!(*table.repair(), repair);
        let note = repair.note("stats.csv", "step").unwrap();
        assert_eq!(
            note,
            "stats.csv: 1 row after the checkpoint removed, to be computed again; 5 rows removed that are damaged or \
             there twice; no row of step 3 to 5"
        );
        table.append(&[row(8)]).unwrap();
        let kept: Vec<u64> = table.rows().unwrap().iter().map(|row| row.step).collect();
        assert_eq!(kept, [1, 2, 6, 7, 8]);
        // All of it gone.
        std::fs::remove_file(&path).unwrap();
        let table = Table::resume(&path, &Row::default(), UP_TO_3).unwrap();
        assert_eq!(table.repair().gaps, [[1, 3]]);
        assert_eq!(Repair::default().note("stats.csv", "step"), None);
    }

    fn rows(step: u64) -> [Row; 2] {
        [row(step), Row { x: -1.0, ..row(step) }]
    }

    #[test]
    fn rows_after_the_last_one_are_cut() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("table.csv");
        let mut table = Table::create(&path, &Row::default()).unwrap();
        // Several rows of one number, as poses of several bodies have.
        for step in 1..=5 {
            table.append(&rows(step)).unwrap();
        }
        let all = std::fs::read(&path).unwrap();
        // A kill at any moment: the rows that are whole and not above 3 stay.
        for length in 0..=all.len() {
            std::fs::write(&path, &all[..length]).unwrap();
            let mut table = Table::resume(&path, &Row::default(), UP_TO_3).unwrap();
            assert_eq!(table.repair().damaged, 0, "cut anywhere");
            let kept = table.rows().unwrap();
            assert!(kept.len() <= 6);
            assert!(kept.iter().enumerate().all(|(n, row)| *row == rows(n as u64 / 2 + 1)[n % 2]));
            assert!(length < all.len() || kept.len() == 6);
            table.append(&[row(9)]).unwrap();
            assert_eq!(table.rows().unwrap().last(), Some(&row(9)));
        }
    }

    #[test]
    fn other_columns_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("table.csv");
        std::fs::write(&path, "step,other\n1,2\n").unwrap();
        let error = Table::resume(&path, &Row::default(), UP_TO_3).err().unwrap().to_string();
        assert!(error.contains("table.csv") && error.contains("other columns"), "{error}");
        assert_eq!(std::fs::read(&path).unwrap(), b"step,other\n1,2\n", "left as it is");
    }
}
