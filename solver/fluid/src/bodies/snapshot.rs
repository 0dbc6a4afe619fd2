//! All that a step depends on, as bytes, so that a simulation goes on with the same bits.
//!
//! ```text
//! "VMBODIES" | postcard: fingerprint of the scene, steps, time, rapier's world | BLAKE3 of all before
//! ```

use super::Bodies;
use crate::Error;
use rapier3d_f64::prelude::PhysicsWorld;
use serde::{Deserialize, Serialize};
use volmap_formats::mesh::guard;
use volmap_runtime::DVec3;

const MAGIC: &[u8; 8] = b"VMBODIES";
const HASH: usize = blake3::OUT_LEN;

#[derive(Serialize)]
struct Written<'a> {
    fingerprint: [u8; HASH],
    steps: u64,
    time: f64,
    world: &'a PhysicsWorld,
}

#[derive(Deserialize)]
struct Read {
    fingerprint: [u8; HASH],
    steps: u64,
    time: f64,
    world: PhysicsWorld,
}

impl Bodies {
    /// The state between two steps; forces that are applied already are not in it.
    ///
    /// # Errors
    /// [`Error::Simulation`] if rapier's state has no bytes.
    pub fn snapshot(&self) -> Result<Vec<u8>, Error> {
        let state = Written {
            fingerprint: self.fingerprint(),
            steps: self.steps,
            time: self.time,
            world: &self.world.physics,
        };
        let mut bytes = postcard::to_extend(&state, MAGIC.to_vec()).map_err(|error| Error::Simulation {
            step: self.steps,
            time: self.time,
            reason: format!("the state of the bodies can't be saved: {error}"),
        })?;
        bytes.extend(blake3::hash(&bytes).as_bytes());
        Ok(bytes)
    }

    /// Takes over a state of the same bodies.
    ///
    /// # Errors
    /// Bytes that are damaged, or of other bodies; then nothing has changed.
    pub fn restore(&mut self, bytes: &[u8]) -> Result<(), String> {
        let damaged = || "the state of the bodies is damaged".to_string();
        let at = bytes.len().checked_sub(HASH).ok_or_else(damaged)?;
        let (state, hash) = bytes.split_at(at);
        if blake3::hash(state).as_bytes() != hash {
            return Err(damaged());
        }
        let state = state.strip_prefix(MAGIC).ok_or_else(damaged)?;
        // The checksum holds for accidents only, so what is read must not be able to panic.
        let read: Read =
            guard::quietly(|| postcard::from_bytes(state)).ok().and_then(Result::ok).ok_or_else(damaged)?;
        if read.fingerprint != self.fingerprint() {
            return Err("the state is that of other bodies: the scene has changed".into());
        }
        let world = &read.world;
        let has = |body: &super::Body| world.bodies.get(body.handle).is_some();
        if world.bodies.len() != self.bodies.len() || !self.bodies.iter().all(has) || !read.time.is_finite() {
            return Err(damaged());
        }
        self.world.physics = read.world;
        (self.steps, self.time) = (read.steps, read.time);
        self.forces.fill([DVec3::ZERO; 2]);
        self.refresh();
        Ok(())
    }

    /// Of what the bodies are, apart from their motion.
    fn fingerprint(&self) -> [u8; HASH] {
        let mut hasher = blake3::Hasher::new();
        hasher.update(format!("{}", self.world.gravity()).as_bytes());
        for body in &self.bodies {
            hasher.update(
                format!("{:?} {:?} {:?} {:?}", body.name, body.start, body.motion, body.mass).as_bytes(),
            );
        }
        hasher.finalize().into()
    }
}
