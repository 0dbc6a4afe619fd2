//! What slicers say of the parts of a model, beside the 3MF model itself: PrusaSlicer in
//! `Metadata/Slic3r_PE_model.config` by ranges of an object's triangles, Bambu Studio and OrcaSlicer in
//! `Metadata/model_settings.config` by components. Neither has a specification; the names are those of their sources
//! (`src/libslic3r/Format/3mf.cpp`, `bbs_3mf.cpp`).

use std::collections::BTreeMap;
use std::io::{BufReader, Read};
use std::ops::RangeInclusive;

use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};

use super::{Archive, bad};
use crate::mesh::budget::Budget;
use crate::mesh::error::MeshError;
use crate::mesh::format::xml::attribute;

/// Triangles of an object that are no part of the solid.
pub struct Volume {
    /// What they are instead.
    pub role: String,
    pub name: String,
    pub triangles: RangeInclusive<usize>,
}

/// All that is no part of the solid.
#[derive(Default)]
pub struct Slicer {
    /// By the object.
    volumes: BTreeMap<u64, Vec<Volume>>,
    /// By the object, and the object that is its component.
    parts: BTreeMap<(u64, u64), String>,
}

/// What is read at the moment.
#[derive(Default)]
struct Open {
    object: u64,
    /// Of a component.
    part: Option<u64>,
    triangles: Option<RangeInclusive<usize>>,
    role: Option<String>,
    name: String,
}

impl Slicer {
    /// Reads what the archive has of such files; one that can't be read is an error, for parts would be taken as solid.
    pub fn read(archive: &mut Archive, budget: &mut Budget) -> Result<Slicer, MeshError> {
        let mut found = Slicer::default();
        for path in ["Metadata/Slic3r_PE_model.config", "Metadata/model_settings.config"] {
            let Ok(entry) = archive.by_name(path) else { continue };
            let limit = budget.left() / 16;
            let mut reader = Reader::from_reader(BufReader::new(entry.take(limit)));
            let mut buffer = Vec::new();
            let mut open = Open::default();
            loop {
                buffer.clear();
                let event = reader.read_event_into(&mut buffer);
                let event = event.map_err(|error| bad(path, format!("{error}; export the file again")))?;
                match &event {
                    Event::Eof => break,
                    Event::Start(tag) => open.begin(tag),
                    Event::Empty(tag) => open.begin(tag),
                    Event::End(tag) => found.end(tag.local_name().as_ref(), &mut open),
                    _ => {}
                }
            }
            let text = usize::try_from(reader.buffer_position()).unwrap_or(usize::MAX);
            budget.take(text, 16, path)?;
        }
        Ok(found)
    }

    fn end(&mut self, tag: &str, open: &mut Open) {
        if !matches!(tag, "volume" | "part") {
            return;
        }
        let (role, name) = (open.role.take(), std::mem::take(&mut open.name));
        let (part, triangles) = (open.part.take(), open.triangles.take());
        let Some(role) = role else { return };
        match (part, triangles) {
            (Some(part), _) => _ = self.parts.insert((open.object, part), role),
            (None, Some(triangles)) => {
                self.volumes.entry(open.object).or_default().push(Volume { role, name, triangles });
            }
            (None, None) => {}
        }
    }

    /// The triangles of an object that are no part of the solid.
    pub fn volumes(&self, object: u64) -> &[Volume] {
        self.volumes.get(&object).map_or(&[], Vec::as_slice)
    }

    /// What a component of an object is, if it is no part of the solid.
    pub fn part(&self, parent: Option<u64>, object: u64) -> Option<&str> {
        self.parts.get(&(parent?, object)).map(String::as_str)
    }
}

impl Open {
    fn begin(&mut self, tag: &BytesStart) {
        let text = |name: &str| attribute(tag, name).unwrap_or_default();
        let number = |name: &str| text(name).trim().parse::<u64>().ok();
        match tag.local_name().as_ref() {
            "object" => *self = Open { object: number("id").unwrap_or(0), ..Open::default() },
            "volume" => {
                let range = || Some(number("firstid")? as usize..=number("lastid")? as usize);
                *self = Open { object: self.object, triangles: range(), ..Open::default() };
            }
            "part" => {
                let role = role(&text("subtype"));
                *self = Open { object: self.object, part: number("id"), role, ..Open::default() };
            }
            "metadata" if self.part.is_some() || self.triangles.is_some() => {
                self.metadata(&text("key"), &text("value"))
            }
            _ => {}
        }
    }

    fn metadata(&mut self, key: &str, value: &str) {
        match key {
            "name" => value.clone_into(&mut self.name),
            "volume_type" => self.role = role(value).or(self.role.take()),
            // Before PrusaSlicer 2.
            "modifier" if value == "1" => self.role = Some("a modifier of the slicer".into()),
            _ => {}
        }
    }
}

/// What a part is, unless it is one of the solid.
fn role(kind: &str) -> Option<String> {
    Some(match kind {
        "" | "ModelPart" | "normal_part" => return None,
        "NegativeVolume" | "negative_part" => "a negative part of the slicer, which is not cut away".into(),
        "ParameterModifier" | "modifier_part" => "a modifier of the slicer".into(),
        "SupportBlocker" | "SupportEnforcer" | "support_blocker" | "support_enforcer" => {
            "for supports".into()
        }
        other => format!("`{}` of the slicer", crate::mesh::text::show(other.as_bytes())),
    })
}
