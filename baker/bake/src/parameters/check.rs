//! What can't be said in one table of parameters; on the command line clap says it.

use super::Parameters;
use crate::density_map::parse_kernel;

/// A parameter that can't be used.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mistake {
    /// Its key.
    pub key: &'static str,
    /// What is wrong with it and the cure.
    pub reason: String,
}

/// Lengths beyond this are mistakes, metres.
const MAX_LENGTH: f64 = 1e12;

impl Parameters {
    /// Whether what is given here goes together, and each for itself can be used with some mesh.
    ///
    /// # Errors
    /// The first mistake.
    pub fn check(&self) -> Result<(), Mistake> {
        self.check_groups()?;
        self.check_density()?;
        for (key, value) in self.lengths() {
            let Some(value) = value else { continue };
            let reason = match key {
                _ if !(-MAX_LENGTH..=MAX_LENGTH).contains(&value) => {
                    format!("{value} is not a usable length")
                }
                "support_radius" | "particle_radius" | "cell_size" if value <= 0.0 => {
                    format!("{value} is not positive")
                }
                "padding" | "weld" if value < 0.0 => format!("{value} is negative"),
                _ => continue,
            };
            return Err(Mistake { key, reason });
        }
        self.check_domain()
    }

    /// Lengths by key.
    fn lengths(&self) -> [(&'static str, Option<f64>); 6] {
        [
            ("support_radius", self.support_radius),
            ("particle_radius", self.particle_radius),
            ("cell_size", self.cell_size),
            ("padding", self.padding),
            ("thickness", self.thickness),
            ("weld", self.weld),
        ]
    }

    fn check_groups(&self) -> Result<(), Mistake> {
        let radius = [
            ("support_radius", self.support_radius.is_some()),
            ("particle_radius", self.particle_radius.is_some()),
        ];
        let cells = [
            ("resolution", self.resolution.is_some()),
            ("cell_size", self.cell_size.is_some()),
            ("tolerance", self.tolerance.is_some()),
        ];
        let precision =
            [("precision", self.precision.is_some()), ("max_rounding", self.max_rounding.is_some())];
        let groups: [&[(&'static str, bool)]; 3] = [&radius, &cells, &precision];
        for group in groups {
            let given: Vec<_> = group.iter().filter(|(_, given)| *given).map(|(key, _)| *key).collect();
            if let [first, second, ..] = given[..] {
                let reason = format!("can't be used with `{first}`; give one of them");
                return Err(Mistake { key: second, reason });
            }
        }
        Ok(())
    }

    fn check_density(&self) -> Result<(), Mistake> {
        if let Some(Err(reason)) = self.kernel.map(|kernel| parse_kernel(kernel.name())) {
            return Err(Mistake { key: "kernel", reason });
        }
        let key = match self {
            _ if self.density != Some(false) => return Ok(()),
            Parameters { kernel: Some(_), .. } => "kernel",
            Parameters { density_quadrature: Some(_), .. } => "density_quadrature",
            _ => return Ok(()),
        };
        Err(Mistake { key, reason: "has no effect with density = false; leave one of them out".into() })
    }

    fn check_domain(&self) -> Result<(), Mistake> {
        let is_box = |corners: [f64; 6]| (0..3).all(|axis| corners[axis] < corners[axis + 3]);
        if self.domain.is_none_or(|domain| is_box(domain.0)) {
            return Ok(());
        }
        let reason = "is not a box; give xmin, ymin, zmin, xmax, ymax, zmax".into();
        Err(Mistake { key: "domain", reason })
    }
}
