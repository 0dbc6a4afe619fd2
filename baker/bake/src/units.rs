//! The suspicion that a file's numbers are in another unit than it was taken for: the one rule for bakes, batches and
//! scenes.
//!
//! A mesh is usually 1 to 1,000 support radii long, where the radius is given, and 1 mm to 100 m where neither that nor
//! the unit is. What lies outside is told, with the unit that would make the length a usual one.

use crate::error::Error;
use crate::input::Input;
use crate::plan::Extent;
use crate::recipe::BakeSettings;
use volmap_formats::text::{number, significant, thousands};

/// Lengths of a mesh, in support radii, that nobody wonders at.
const USUAL_RADII: [f64; 2] = [1.0, 1000.0];
/// The same in metres, if the support radius follows from the mesh.
const USUAL_METRES: [f64; 2] = [1e-3, 100.0];
/// Lengths that a unit is proposed for: in support radii, and in metres.
const LIKELY_RADII: [f64; 2] = [8.0, 400.0];
const LIKELY_METRES: [f64; 2] = [0.05, 20.0];

/// Units that files have, the likelier first: name, plural, metres.
const UNITS: [(&str, &str, f64); 5] = [
    ("mm", "millimetres", 1e-3),
    ("cm", "centimetres", 1e-2),
    ("in", "inches", 0.0254),
    ("ft", "feet", 0.3048),
    ("m", "metres", 1.0),
];

/// What the rule goes by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lengths {
    /// Longest edge of the placed mesh's box, metres.
    pub size: f64,
    /// Metres per unit of the file's numbers, as they were taken.
    pub unit: f64,
    /// Somebody said so, rather than the file or nobody.
    pub unit_is_given: bool,
    /// The map's support radius, metres; none if it follows from the mesh.
    pub support_radius: Option<f64>,
    /// That of the kernels, metres, if it is another.
    pub kernel_radius: Option<f64>,
}

impl Lengths {
    /// Those of a mesh and of what is given for its bake.
    pub fn of(input: &Input, extent: &Extent, settings: &BakeSettings) -> Lengths {
        Lengths {
            size: (extent.max - extent.min).max_element(),
            unit: input.placement.unit,
            unit_is_given: settings.unit_is_given,
            support_radius: settings.map.support_radius,
            kernel_radius: settings.kernel_radius,
        }
    }

    /// What is told of a length that isn't usual, with the cure; names of parameters stand in backquotes.
    pub fn suspicion(&self) -> Option<String> {
        let [least, most] = self.usual();
        let is_unknown = self.support_radius.is_some() || !self.unit_is_given;
        if !is_unknown || (least..=most).contains(&self.size) || !self.size.is_finite() {
            return None;
        }
        let small = match self.support_radius {
            Some(radius) if self.size < radius => "; a map of it holds next to nothing of its shape",
            _ => "",
        };
        Some(format!("{}{small}; {}", self.told(), self.cure()))
    }

    /// The length in words: `the mesh is 1,000 m long, 100,000 support radii`.
    pub fn told(&self) -> String {
        let radii = match (self.support_radius, self.kernel_radius()) {
            (Some(radius), _) if self.size < radius => {
                format!(", less than the support radius of {} m", number(radius))
            }
            (_, Some(radius)) => format!(", {} support radii", grouped(self.size / radius)),
            _ => String::new(),
        };
        format!("the mesh is {} m long{radii}", grouped(self.size))
    }

    fn kernel_radius(&self) -> Option<f64> {
        self.kernel_radius.or(self.support_radius)
    }

    /// An error of the plan, with the mesh's length before it where that is what it comes from.
    pub fn explain(&self, error: Error) -> Error {
        let about = match (&error, self.suspicion()) {
            (Error::Memory { .. } | Error::Setting { .. }, Some(suspicion)) => suspicion,
            (Error::Memory { .. }, None) => self.told(),
            _ => return error,
        };
        Error::Sized { about, reason: Box::new(error) }
    }

    fn usual(&self) -> [f64; 2] {
        let [least, most] = USUAL_RADII;
        let radii = self.support_radius.zip(self.kernel_radius());
        radii.map_or(USUAL_METRES, |(map, kernel)| [least * map, most * kernel])
    }

    fn cure(&self) -> String {
        let [least, most] =
            self.kernel_radius().map_or(LIKELY_METRES, |radius| LIKELY_RADII.map(|n| n * radius));
        let small = self.size < self.usual()[0];
        let size_in = |metres: f64| self.size / self.unit * metres;
        let likely = UNITS.iter().find(|(_, _, metres)| {
            (*metres > self.unit) == small && (least..=most).contains(&size_in(*metres))
        });
        match likely {
            Some((unit, plural, metres)) => {
                let size = grouped(size_in(*metres));
                format!("if its numbers are {plural}, give `unit` {unit} ({size} m then)")
            }
            None if small && self.support_radius.is_some() => {
                "check `unit` and `scale`, or take smaller particles (`particle_radius`)".to_owned()
            }
            None => "check `unit` and `scale`".to_owned(),
        }
    }
}

/// Four digits; those of thousands in groups.
fn grouped(x: f64) -> String {
    if (1e4..1e15).contains(&x) { thousands(x.round() as u64) } else { significant(x, 4) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lengths(size: f64, support_radius: Option<f64>) -> Lengths {
        Lengths { size, unit: 1.0, unit_is_given: false, support_radius, kernel_radius: None }
    }

    fn said(lengths: Lengths) -> String {
        lengths.suspicion().unwrap_or_default()
    }

    #[test]
    fn millimetres_taken_for_metres_are_told() {
        // A bracket and a flange of a metre, a spider of two, an inch-sized part.
        assert_eq!(
            said(lengths(1000.0, Some(0.01))),
            "the mesh is 1,000 m long, 100,000 support radii; if its numbers are millimetres, give `unit` mm (1 m then)"
        );
        assert!(
            said(lengths(1000.0, None))
                .ends_with("long; if its numbers are millimetres, give `unit` mm (1 m then)")
        );
        assert!(
            said(lengths(194.0, Some(0.1)))
                .contains("if its numbers are centimetres, give `unit` cm (1.94 m then)")
        );
        assert!(said(lengths(150.0, Some(0.05))).contains("`unit` cm (1.5 m then)"));
        assert!(said(lengths(600.0, Some(0.5))).contains("`unit` cm (6 m then)"));
    }

    #[test]
    fn meshes_smaller_than_the_support_radius_are_told() {
        let ring = said(lengths(0.02, Some(0.1)));
        assert!(
            ring.starts_with("the mesh is 0.02 m long, less than the support radius of 0.1 m; "),
            "{ring}"
        );
        assert!(
            ring.ends_with("check `unit` and `scale`, or take smaller particles (`particle_radius`)"),
            "{ring}"
        );
        assert!(!said(lengths(0.08, Some(0.1))).is_empty(), "a cup");
        // Metres in a file that says millimetres.
        let metres = Lengths { unit: 1e-3, ..lengths(2e-3, Some(0.1)) };
        assert!(
            said(metres).contains("if its numbers are metres, give `unit` m (2 m then)"),
            "{}",
            said(metres)
        );
        assert!(!said(lengths(1e-4, None)).is_empty());
    }

    #[test]
    fn usual_lengths_are_not() {
        // The sample meshes in their scenes and by default, the paper's canyon, a ball of the radius.
        for (size, radius) in
            [(1.3, 0.1), (38.4, 0.1), (38.4, 0.4), (3.1, 0.05), (1.0, 0.04), (0.1, 0.1), (500.0, 2.0)]
        {
            assert_eq!(lengths(size, Some(radius)).suspicion(), None, "{size} {radius}");
        }
        // A scene's map may have a quarter of the kernels' radius.
        let canyon = Lengths { kernel_radius: Some(0.1), ..lengths(38.4, Some(0.025)) };
        let pebble = Lengths { size: 0.05, ..canyon };
        assert_eq!((canyon.suspicion(), pebble.suspicion()), (None, None));
        for size in [0.02, 0.3, 1.5, 38.4, 99.0] {
            assert_eq!(lengths(size, None).suspicion(), None, "{size}");
        }
        // Whoever gives the unit knows it, as long as the radius doesn't speak against it.
        assert_eq!(Lengths { unit_is_given: true, ..lengths(2000.0, None) }.suspicion(), None);
        assert!(Lengths { unit_is_given: true, ..lengths(2000.0, Some(0.01)) }.suspicion().is_some());
    }

    #[test]
    fn what_does_not_fit_the_memory_is_told_by_its_length() {
        let memory = || Error::Memory { needed: 40 << 30, allowed: 4 << 30 };
        let text = lengths(194.0, Some(0.1)).explain(memory()).to_string();
        assert!(
            text.starts_with("the mesh is 194 m long, 1,940 support radii; if its numbers are cent"),
            "{text}"
        );
        let text = lengths(12.0, Some(0.02)).explain(memory()).to_string();
        assert!(
            text.starts_with("the mesh is 12 m long, 600 support radii: the bake would need about"),
            "{text}"
        );
        let setting = lengths(1.0, Some(0.1)).explain(Error::setting("domain", "is empty"));
        assert_eq!(setting.to_string(), "domain: is empty");
    }
}
