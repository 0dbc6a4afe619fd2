//! Colours that keep their meaning for colour-blind eyes and in print: viridis and cividis for values (Nunez
//! et al. 2018), ColorBrewer's RdBu for signed ones, the colours of Okabe and Ito (2008) for lines and
//! categories.

/// Red, green, blue of sRGB.
pub type Rgb = [u8; 3];

/// Black.
pub const BLACK: Rgb = [0, 0, 0];
/// White.
pub const WHITE: Rgb = [255, 255, 255];
/// Letters and axes.
pub const INK: Rgb = [26, 26, 26];
/// Far from the surface in the fluid: nothing stored.
pub const FLUID: Rgb = [214, 217, 222];
/// Deep in the solid: nothing stored.
pub const SOLID: Rgb = [150, 153, 159];
/// Okabe and Ito's colours: blue, vermillion, green, orange, sky blue, purple, yellow.
pub const DISTINCT: [Rgb; 7] = [
    [0, 114, 178],
    [213, 94, 0],
    [0, 158, 115],
    [230, 159, 0],
    [86, 180, 233],
    [204, 121, 167],
    [240, 228, 66],
];

/// From numbers to colours.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ColourMap {
    /// Dark violet to yellow: for values.
    #[default]
    Viridis,
    /// Dark blue to yellow; nearly the same for colour-blind eyes.
    Cividis,
    /// White to dark red, as the paper's Fig. 6b: for the size of errors.
    Reds,
    /// Deep blue to the white of foam: for the speed of water.
    Water,
    /// Blue (negative), white (zero), red (positive): for signed numbers, in limits that are balanced about
    /// zero.
    BlueRed,
}

impl ColourMap {
    /// The colour of a place from 0 to 1; beyond them that of the end.
    pub fn at(self, place: f64) -> Rgb {
        let place = if place.is_nan() { 0.0 } else { place.clamp(0.0, 1.0) };
        let colour = match self {
            ColourMap::Viridis => colorous::VIRIDIS.eval_continuous(place),
            ColourMap::Cividis => colorous::CIVIDIS.eval_continuous(place),
            ColourMap::Reds => colorous::REDS.eval_continuous(place),
            ColourMap::Water => colorous::BLUES.eval_continuous(0.95 - 0.9 * place),
            ColourMap::BlueRed => colorous::RED_BLUE.eval_continuous(1.0 - place),
        };
        [colour.r, colour.g, colour.b]
    }

    /// Whether its middle stands for zero.
    pub fn is_diverging(self) -> bool {
        self == ColourMap::BlueRed
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Lightness of CIE 1976 L*a*b*, 0 to 100.
    fn lightness(rgb: Rgb) -> f64 {
        let linear = rgb.map(|c| {
            let c = f64::from(c) / 255.0;
            if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
        });
        let y = 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2];
        if y > 0.008856 { 116.0 * y.cbrt() - 16.0 } else { 903.3 * y }
    }

    fn steps(map: ColourMap) -> Vec<f64> {
        (0..=64).map(|n| lightness(map.at(f64::from(n) / 64.0))).collect()
    }

    #[test]
    fn lightness_of_values_rises_evenly() {
        for map in [ColourMap::Viridis, ColourMap::Cividis] {
            let steps = steps(map);
            let mean = (steps[64] - steps[0]) / 64.0;
            assert!(
                steps.windows(2).all(|w| w[1] - w[0] > 0.5 * mean && w[1] - w[0] < 1.6 * mean),
                "{map:?} {steps:?}"
            );
        }
        let water = steps(ColourMap::Water);
        assert!(water.windows(2).all(|w| w[1] > w[0]) && water[0] < 35.0 && water[64] > 90.0, "{water:?}");
        let reds = steps(ColourMap::Reds);
        assert!(reds.windows(2).all(|w| w[1] < w[0] + 0.2) && reds[0] > 95.0, "{reds:?}");
    }

    #[test]
    fn signs_are_equally_strong() {
        let steps = steps(ColourMap::BlueRed);
        assert!(steps[32] > 93.0, "zero is almost white");
        for n in 0..32 {
            assert!((steps[n] - steps[64 - n]).abs() < 8.0, "{n}: {} {}", steps[n], steps[64 - n]);
            assert!(steps[n] < steps[n + 1]);
        }
        let [blue, red] = [ColourMap::BlueRed.at(0.1), ColourMap::BlueRed.at(0.9)];
        assert!(blue[2] > blue[0] && red[0] > red[2]);
    }

    #[test]
    fn places_beyond_the_ends() {
        assert_eq!(ColourMap::Viridis.at(-1.0), ColourMap::Viridis.at(0.0));
        assert_eq!(ColourMap::Viridis.at(f64::INFINITY), ColourMap::Viridis.at(1.0));
        assert_eq!(ColourMap::Viridis.at(f64::NAN), ColourMap::Viridis.at(0.0));
    }
}
