//! A CSV table that grows row by row, in a program that may be killed at any moment. Each row is written at once, and a
//! run that resumes cuts the table after the last row that its checkpoint knows of.

use super::io_error;
use crate::error::Error;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::fs::{File, OpenOptions};
use std::io::{ErrorKind, Seek, SeekFrom, Write};
use std::marker::PhantomData;
use std::path::{Path, PathBuf};

/// A growing table of rows of one kind. The first column is a number that never decreases.
pub struct Table<Row> {
    path: PathBuf,
    file: File,
    rows: PhantomData<Row>,
}

impl<Row: Serialize + DeserializeOwned> Table<Row> {
    /// A table without rows, in place of an older one. The `sample` gives the names of the columns.
    ///
    /// # Errors
    /// A file that can't be made.
    pub fn create(path: &Path, sample: &Row) -> Result<Table<Row>, Error> {
        let mut file = File::create(path).map_err(io_error(path))?;
        file.write_all(&header(sample)).map_err(io_error(path))?;
        Ok(Table { path: path.to_owned(), file, rows: PhantomData })
    }

    /// A table that continues: rows whose first column is above `last` are removed, as is an incomplete one. A missing
    /// table is created.
    ///
    /// # Errors
    /// A file that can't be read or written, or that has other columns.
    pub fn resume(path: &Path, sample: &Row, last: u64) -> Result<Table<Row>, Error> {
        let bytes = match std::fs::read(path) {
            Ok(bytes) => bytes,
            Err(error) if error.kind() == ErrorKind::NotFound => return Table::create(path, sample),
            Err(error) => return Err(io_error(path)(error)),
        };
        let header = header(sample);
        if !bytes.starts_with(&header) {
            // The program may have been killed before the header was complete.
            if header.starts_with(&bytes) {
                return Table::create(path, sample);
            }
            let reason =
                "has other columns, so it can't be continued; move it away, or simulate into another folder";
            return Err(io_error(path)(std::io::Error::new(ErrorKind::InvalidData, reason)));
        }
        let kept = kept_length(&bytes, last).max(header.len() as u64);
        let mut file = OpenOptions::new().write(true).open(path).map_err(io_error(path))?;
        file.set_len(kept).and_then(|()| file.seek(SeekFrom::End(0))).map_err(io_error(path))?;
        Ok(Table { path: path.to_owned(), file, rows: PhantomData })
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

fn header<Row: Serialize>(sample: &Row) -> Vec<u8> {
    let both = to_csv(&[sample], true);
    both.split_inclusive(|&byte| byte == b'\n').next().unwrap_or_default().to_vec()
}

fn to_csv<Row: Serialize>(rows: &[Row], with_header: bool) -> Vec<u8> {
    let mut writer = csv::WriterBuilder::new().has_headers(with_header).from_writer(Vec::new());
    rows.iter().for_each(|row| writer.serialize(row).expect("rows are flat, and memory takes all"));
    writer.into_inner().expect("memory takes all")
}

/// Bytes of the header and the complete rows up to number `last`.
fn kept_length(bytes: &[u8], last: u64) -> u64 {
    let mut reader = csv::Reader::from_reader(bytes);
    let mut record = csv::ByteRecord::new();
    let mut kept = 0;
    while let Ok(true) = reader.read_byte_record(&mut record) {
        let end = reader.position().byte();
        let number = record.get(0).and_then(|text| std::str::from_utf8(text).ok()?.parse::<u64>().ok());
        let whole = end > 0 && bytes.get(end as usize - 1) == Some(&b'\n');
        if !whole || number.is_none_or(|number| number > last) {
            break;
        }
        kept = end;
    }
    kept
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

    #[test]
    fn rows_after_the_last_one_are_cut() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("table.csv");
        let mut table = Table::create(&path, &Row::default()).unwrap();
        // Several rows of one number, as poses of several bodies have.
        for step in 1..=5 {
            table.append(&[row(step), row(step)]).unwrap();
        }
        let all = std::fs::read(&path).unwrap();
        // A kill at any moment: the rows that are whole and not above 3 stay.
        for length in 0..=all.len() {
            std::fs::write(&path, &all[..length]).unwrap();
            let mut table = Table::resume(&path, &Row::default(), 3).unwrap();
            let kept = table.rows().unwrap();
            assert!(kept.len() <= 6 && kept.iter().enumerate().all(|(n, r)| *r == row(n as u64 / 2 + 1)));
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
        let error = Table::resume(&path, &Row::default(), 3).err().unwrap().to_string();
        assert!(error.contains("table.csv") && error.contains("other columns"), "{error}");
        assert_eq!(std::fs::read(&path).unwrap(), b"step,other\n1,2\n", "left as it is");
    }
}
