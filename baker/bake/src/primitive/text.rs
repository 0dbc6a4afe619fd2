//! Primitives as texts: `sphere:0.5`, `box:1,2,3`; and read from documents, as a text or as a table.

use super::Primitive;
use serde::de::value::MapAccessDeserializer;
use serde::de::{MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::fmt::{self, Display, Formatter};
use std::str::FromStr;

/// How they are written.
const USAGE: &str = "give box:X,Y,Z, sphere:RADIUS, cylinder:RADIUS,HEIGHT, capsule:RADIUS,LENGTH or plane:NX,NY,NZ \
                     (metres; the axis is y)";

impl FromStr for Primitive {
    type Err = String;

    fn from_str(text: &str) -> Result<Primitive, String> {
        let usage = || format!("`{text}` is no shape; {USAGE}");
        let (name, numbers) = text.split_once(':').ok_or_else(usage)?;
        let numbers: Result<Vec<f64>, _> = numbers.split(',').map(|number| number.trim().parse()).collect();
        let numbers = numbers.map_err(|_| usage())?;
        let found = match (name.trim(), numbers.as_slice()) {
            ("box", &[x, y, z]) => Primitive::Box { size: [x, y, z] },
            ("sphere", &[radius]) => Primitive::Sphere { radius },
            ("cylinder", &[radius, height]) => Primitive::Cylinder { radius, height },
            ("capsule", &[radius, length]) => Primitive::Capsule { radius, length },
            ("plane", &[x, y, z]) => Primitive::Plane { normal: [x, y, z], within: None },
            ("plane", &[x, y, z, a, b, c, d, e, f]) => {
                Primitive::Plane { normal: [x, y, z], within: Some([[a, b, c], [d, e, f]]) }
            }
            _ => return Err(usage()),
        };
        found.check().map(|()| found)
    }
}

impl Display for Primitive {
    /// As it is read.
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        let numbers = match *self {
            Primitive::Box { size } => size.to_vec(),
            Primitive::Sphere { radius } => vec![radius],
            Primitive::Cylinder { radius, height } => vec![radius, height],
            Primitive::Capsule { radius, length } => vec![radius, length],
            Primitive::Plane { normal, within } => {
                normal.into_iter().chain(within.into_iter().flatten().flatten()).collect()
            }
        };
        let numbers: Vec<String> = numbers.iter().map(f64::to_string).collect();
        write!(f, "{}:{}", self.name(), numbers.join(","))
    }
}

impl Serialize for Primitive {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl<'de> Deserialize<'de> for Primitive {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let found = deserializer.deserialize_any(TextOrTable)?;
        found.check().map_err(serde::de::Error::custom)?;
        Ok(found)
    }
}

struct TextOrTable;

impl<'de> Visitor<'de> for TextOrTable {
    type Value = Primitive;

    fn expecting(&self, f: &mut Formatter) -> fmt::Result {
        f.write_str("a shape, as { sphere = { radius = 0.5 } }")
    }

    fn visit_str<E: serde::de::Error>(self, text: &str) -> Result<Primitive, E> {
        text.parse().map_err(E::custom)
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Primitive, A::Error> {
        // The derived reader, not the trait's.
        Primitive::deserialize(MapAccessDeserializer::new(map))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_and_tables_are_read_alike() {
        let texts = [
            "box:1,2,3",
            "sphere:0.5",
            "cylinder:0.25,1",
            "capsule:0.1,1e-3",
            "plane:0,1,0",
            "plane:0,0,-2,-1,-1,-1,1,1,1",
        ];
        let tables = [
            r#"{"box": {"size": [1, 2, 3]}}"#,
            r#"{"sphere": {"radius": 0.5}}"#,
            r#"{"cylinder": {"radius": 0.25, "height": 1}}"#,
            r#"{"capsule": {"radius": 0.1, "length": 0.001}}"#,
            r#"{"plane": {"normal": [0, 1, 0]}}"#,
            r#"{"plane": {"normal": [0, 0, -2], "within": [[-1, -1, -1], [1, 1, 1]]}}"#,
        ];
        for (text, table) in texts.iter().zip(tables) {
            let shape: Primitive = text.parse().unwrap();
            assert_eq!(serde_json::from_str::<Primitive>(table).unwrap(), shape);
            let written = serde_json::to_string(&shape).unwrap();
            assert_eq!(serde_json::from_str::<Primitive>(&written).unwrap(), shape, "{written}");
            assert_eq!(shape.to_string().parse(), Ok(shape));
        }
    }

    #[test]
    fn bodies_that_there_are_not_are_refused() {
        for (text, why) in [
            ("ball:1", "`ball:1` is no shape; give box:X,Y,Z"),
            ("box:1,2", "is no shape"),
            ("sphere", "is no shape"),
            ("sphere:-1", "a sphere with a radius of -1 m; give 1e-9 to 1e9 m"),
            ("sphere:nan", "a radius of NaN m"),
            ("box:1,0,1", "a box with a size of 0 m"),
            ("capsule:1,inf", "a length of inf m"),
            ("plane:0,0,0", "give one with a length"),
            ("plane:0,1,0,0,0,0,1,0,1", "which is no box"),
        ] {
            let error = text.parse::<Primitive>().unwrap_err();
            assert!(error.contains(why), "{error}");
        }
        for (json, why) in [
            (r#"{"sphere": {"radius": 0}}"#, "a radius of 0 m"),
            (r#"{"sphere": {"diameter": 1}}"#, "unknown field `diameter`"),
            (r#"{"cone": {}}"#, "unknown variant `cone`"),
            ("3", "expected a shape, as { sphere = { radius = 0.5 } }"),
        ] {
            let error = serde_json::from_str::<Primitive>(json).unwrap_err().to_string();
            assert!(error.contains(why), "{error}");
        }
    }
}
