//! Prescribed motions: pose and velocity at any time. Kim, Kim and Shin 1995, *A General Construction Scheme
//! for Unit Quaternion Curves with Simple High Order Derivatives*, for smooth rotations.

use volmap_runtime::{DQuat, DVec3, Pose};

/// A motion that nothing can disturb, relative to the body's pose in its description.
#[derive(Clone, Debug, PartialEq)]
pub enum Path {
    /// From key to key.
    Keys(Keys),
    /// Around an axis for ever.
    Spin(Spin),
}

/// Poses at times.
#[derive(Clone, Debug, PartialEq)]
pub struct Keys {
    /// At least one, with growing times. Before the first and after the last the body rests.
    pub keys: Vec<Key>,
    /// How it gets from one to the next.
    pub interpolation: Interpolation,
    /// Begins anew after the last key, which has the first one's pose.
    pub repeat: bool,
}

/// One pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Key {
    /// Seconds.
    pub time: f64,
    /// Added to the body's place, metres.
    pub translation: DVec3,
    /// Turns the body about its map's origin, after its own rotation; of length 1.
    pub rotation: DQuat,
}

/// Between two keys.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Interpolation {
    /// Constant velocities, which jump at the keys.
    Linear,
    /// Continuous velocities (cubic Hermite); a path that doesn't repeat starts and ends at rest.
    #[default]
    Smooth,
}

/// Constant rotation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spin {
    /// Axis in the world, of length 1.
    pub axis: DVec3,
    /// A point of the axis in the world, metres.
    pub centre: DVec3,
    /// rad/s, counter-clockwise when the axis points at the viewer.
    pub speed: f64,
}

/// Where and how fast.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moving {
    /// Where the map stands.
    pub pose: Pose,
    /// Velocity of the map's origin, m/s.
    pub velocity: DVec3,
    /// Angular velocity in the world, rad/s.
    pub angular_velocity: DVec3,
}

impl Path {
    /// Pose and velocity at a time, of a body that the path found at `start`.
    pub fn at(&self, time: f64, start: Pose) -> Moving {
        match self {
            Path::Keys(keys) => keys.at(time, start),
            Path::Spin(spin) => spin.at(time, start),
        }
    }

    /// What makes the path impossible.
    pub(super) fn defect(&self) -> Option<String> {
        match self {
            Path::Keys(keys) => keys.defect(),
            Path::Spin(Spin { axis, centre, speed }) => {
                let finite = axis.is_finite() && centre.is_finite() && speed.is_finite();
                let good = finite && (axis.length() - 1.0).abs() < 1e-6;
                (!good)
                    .then(|| format!("a spin of {speed} rad/s around {axis}: take a unit axis and numbers"))
            }
        }
    }
}

impl Spin {
    fn at(&self, time: f64, start: Pose) -> Moving {
        let turn = DQuat::from_axis_angle(self.axis.normalize(), self.speed * time);
        let arm = turn * (start.translation - self.centre);
        let angular_velocity = self.speed * self.axis.normalize();
        Moving {
            pose: Pose { rotation: (turn * start.rotation).normalize(), translation: self.centre + arm },
            velocity: angular_velocity.cross(arm),
            angular_velocity,
        }
    }
}

impl Keys {
    fn defect(&self) -> Option<String> {
        let keys = &self.keys;
        if keys.is_empty() {
            return Some("a path without keys: give one at least".into());
        }
        let finite = |k: &Key| k.time.is_finite() && k.translation.is_finite() && k.rotation.is_finite();
        if let Some(key) = keys.iter().find(|k| !finite(k) || !k.rotation.is_normalized()) {
            return Some(format!("the key at {} s has no finite pose with a unit rotation", key.time));
        }
        if let Some(pair) = keys.windows(2).find(|pair| pair[1].time <= pair[0].time) {
            return Some(format!("the key at {} s comes after the one at {} s", pair[1].time, pair[0].time));
        }
        let (first, last) = (keys[0], keys[keys.len() - 1]);
        let apart = (first.translation - last.translation).length() > 1e-9
            || rotation_vector(first.rotation.conjugate() * last.rotation).length() > 1e-9;
        (self.repeat && (keys.len() < 2 || apart))
            .then(|| "a path repeats only if its last key has the pose of its first".into())
    }

    fn at(&self, time: f64, start: Pose) -> Moving {
        let [first, last] = [self.keys[0], self.keys[self.keys.len() - 1]];
        let time = match self.repeat {
            true => first.time + (time - first.time).rem_euclid(last.time - first.time),
            false => time,
        };
        let next = self.keys.partition_point(|key| key.time <= time);
        if next == 0 || next == self.keys.len() {
            let key = if next == 0 { first } else { last };
            return placed(start, key.translation, DVec3::ZERO, key.rotation, DVec3::ZERO);
        }
        let (a, b) = (self.keys[next - 1], self.keys[next]);
        let span = b.time - a.time;
        let u = (time - a.time) / span;
        if self.interpolation == Interpolation::Linear {
            let velocity = (b.translation - a.translation) / span;
            let turn = rotation_vector(b.rotation * a.rotation.conjugate());
            let rotation = DQuat::from_scaled_axis(turn * u) * a.rotation;
            return placed(start, a.translation + velocity * (u * span), velocity, rotation, turn / span);
        }
        let (speeds, turns) = ([self.velocity(next - 1), self.velocity(next)], span / 3.0);
        let (translation, velocity) = hermite(a.translation, b.translation, speeds.map(|s| s.0), span, u);
        let (rotation, angular) = hermite_rotation(a.rotation, b.rotation, speeds.map(|s| s.1 * turns), u);
        placed(start, translation, velocity, rotation, angular / span)
    }

    /// At a key: velocity, and angular velocity in the frame of the key; from its neighbours (Catmull and Rom
    /// 1974).
    fn velocity(&self, at: usize) -> (DVec3, DVec3) {
        let keys = &self.keys;
        let last = keys.len() - 1;
        let (before, after, span) = match at {
            at if at > 0 && at < last => (at - 1, at + 1, keys[at + 1].time - keys[at - 1].time),
            _ if self.repeat => {
                let span = keys[1].time - keys[0].time + keys[last].time - keys[last - 1].time;
                (last - 1, 1, span)
            }
            _ => return (DVec3::ZERO, DVec3::ZERO),
        };
        let (before, after, here) = (keys[before], keys[after], keys[at].rotation);
        // In two parts, each less than half a turn.
        let turn = rotation_vector(before.rotation.conjugate() * here)
            + rotation_vector(here.conjugate() * after.rotation);
        ((after.translation - before.translation) / span, turn / span)
    }
}

/// A path's pose applied to a body that stood at `start`.
fn placed(start: Pose, translation: DVec3, velocity: DVec3, rotation: DQuat, angular: DVec3) -> Moving {
    let pose = Pose {
        rotation: (rotation * start.rotation).normalize(),
        translation: start.translation + translation,
    };
    Moving { pose, velocity, angular_velocity: angular }
}

/// Cubic with given ends and velocities there; value and velocity.
fn hermite(a: DVec3, b: DVec3, [va, vb]: [DVec3; 2], span: f64, u: f64) -> (DVec3, DVec3) {
    let (blend, slope) = (u * u * (3.0 - 2.0 * u), 6.0 * u * (1.0 - u));
    let value =
        a + (b - a) * blend + va * (span * u * (1.0 - u) * (1.0 - u)) + vb * (span * u * u * (u - 1.0));
    let velocity = (b - a) * (slope / span) + va * ((1.0 - u) * (1.0 - 3.0 * u)) + vb * (u * (3.0 * u - 2.0));
    (value, velocity)
}

/// Rotation between `a` and `b`, and angular velocity per `u` in the world: the Hermite curve of Kim et al.
/// 1995, section 4.2. `ends`: a third of the segment's time times the angular velocities, in the frames of
/// `a` and `b`.
fn hermite_rotation(a: DQuat, b: DQuat, ends: [DVec3; 2], u: f64) -> (DQuat, DVec3) {
    let [first, last] = ends.map(DQuat::from_scaled_axis);
    let middle = rotation_vector(first.conjugate() * a.conjugate() * b * last.conjugate());
    let v = 1.0 - u;
    let sums = [1.0 - v * v * v, u * u * (3.0 - 2.0 * u), u * u * u];
    let slopes = [3.0 * v * v, 6.0 * u * v, 3.0 * u * u];
    let (mut rotation, mut angular) = (a, DVec3::ZERO);
    for ((turn, sum), slope) in [ends[0], middle, ends[1]].into_iter().zip(sums).zip(slopes) {
        angular += rotation * (turn * slope);
        rotation *= DQuat::from_scaled_axis(turn * sum);
    }
    (rotation, angular)
}

/// Axis times angle, of at most half a turn; exact for small ones.
pub(super) fn rotation_vector(q: DQuat) -> DVec3 {
    let q = if q.w < 0.0 { -q } else { q };
    let (axis, sine) = (DVec3::new(q.x, q.y, q.z), DVec3::new(q.x, q.y, q.z).length());
    if sine == 0.0 { DVec3::ZERO } else { axis * (2.0 * sine.atan2(q.w) / sine) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn key(time: f64, x: f64, axis: DVec3, angle: f64) -> Key {
        Key { time, translation: DVec3::new(x, 0.5 * x, 1.0), rotation: DQuat::from_axis_angle(axis, angle) }
    }

    fn start() -> Pose {
        Pose {
            rotation: DQuat::from_axis_angle(DVec3::new(0.6, 0.0, 0.8), 0.7),
            translation: DVec3::new(1.0, 2.0, 3.0),
        }
    }

    fn paths() -> Vec<Path> {
        let mut keys = vec![
            key(0.5, 0.0, DVec3::X, 0.0),
            key(1.0, 1.0, DVec3::Y, 1.0),
            key(2.5, -1.0, DVec3::Z, -2.0),
            key(3.0, 0.3, DVec3::X, 0.4),
        ];
        let open = Keys { keys: keys.clone(), interpolation: Interpolation::Smooth, repeat: false };
        let linear = Keys { interpolation: Interpolation::Linear, ..open.clone() };
        keys[3] = Key { time: 3.0, ..keys[0] };
        let closed = Keys { keys, interpolation: Interpolation::Smooth, repeat: true };
        let spin = Spin { axis: DVec3::new(0.0, 0.6, 0.8), centre: DVec3::new(0.0, 1.0, 0.0), speed: -3.0 };
        vec![Path::Keys(open), Path::Keys(linear), Path::Keys(closed), Path::Spin(spin)]
    }

    #[test]
    fn velocities_are_the_derivatives_of_poses() {
        let h = 1e-6;
        for path in paths() {
            for n in 0..60 {
                let time = 0.037 + 0.0613 * f64::from(n);
                let [before, now, after] = [-h, 0.0, h].map(|shift| path.at(time + shift, start()));
                let velocity = (after.pose.translation - before.pose.translation) / (2.0 * h);
                let turn =
                    rotation_vector(after.pose.rotation * before.pose.rotation.conjugate()) / (2.0 * h);
                assert!((velocity - now.velocity).length() < 1e-7, "{path:?} at {time}");
                assert!((turn - now.angular_velocity).length() < 1e-7, "{path:?} at {time}");
            }
        }
    }

    #[test]
    fn keys_are_met() {
        for path in paths() {
            let Path::Keys(keys) = &path else { continue };
            for key in &keys.keys[..3] {
                let pose = path.at(key.time, start()).pose;
                assert!((pose.translation - start().translation - key.translation).length() < 1e-12);
                let off = (key.rotation * start().rotation).conjugate() * pose.rotation;
                assert!(rotation_vector(off).length() < 1e-12);
            }
        }
    }

    #[test]
    fn smooth_velocities_are_continuous() {
        for path in [&paths()[0], &paths()[2]] {
            let Path::Keys(keys) = path else { unreachable!() };
            for key in &keys.keys {
                let [before, after] = [-1e-9, 1e-9].map(|shift| path.at(key.time + shift, start()));
                assert!((before.velocity - after.velocity).length() < 1e-6);
                assert!((before.angular_velocity - after.angular_velocity).length() < 1e-6);
            }
        }
    }

    #[test]
    fn impossible_paths_are_named() {
        for path in paths() {
            assert_eq!(path.defect(), None);
        }
        let Path::Keys(good) = &paths()[0] else { unreachable!() };
        let with = |change: fn(&mut Keys)| {
            let mut keys = good.clone();
            change(&mut keys);
            Path::Keys(keys).defect()
        };
        assert!(with(|k| k.keys.clear()).is_some());
        assert!(with(|k| k.keys[1].time = 0.5).is_some());
        assert!(with(|k| k.keys[1].translation.x = f64::NAN).is_some());
        assert!(with(|k| k.keys[1].rotation *= 2.0).is_some());
        assert!(with(|k| k.repeat = true).is_some());
        let spin = Spin { axis: DVec3::ZERO, centre: DVec3::ZERO, speed: 1.0 };
        assert!(Path::Spin(spin).defect().is_some());
    }
}
