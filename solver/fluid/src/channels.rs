//! Channels: named numbers or vectors that every particle carries from one step to the next, beside its place and
//! velocity.
//!
//! A force declares those it needs. They are then added, put into another order and removed with the particles, and
//! checkpoints and frames have them, all without another line.

use rayon::prelude::*;

/// What a force says of a channel that it needs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChannelDeclaration {
    /// Its name, in checkpoints and frames: unique, and none of those of [`Particles`](crate::particles::Particles).
    pub name: &'static str,
    /// What a particle begins with, and so whether it is numbers or vectors.
    pub initial: Initial,
    /// Whether frames have it.
    pub in_frames: bool,
}

/// What a particle begins with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Initial {
    /// A number.
    Number(f32),
    /// A vector.
    Vector([f32; 3]),
}

/// A channel: a value for each particle, in their order.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// What was declared.
    pub declaration: ChannelDeclaration,
    /// The values.
    pub values: ChannelValues,
}

/// Values of a channel.
#[derive(Clone, Debug, PartialEq)]
pub enum ChannelValues {
    /// A number for each particle.
    Numbers(Vec<f32>),
    /// A vector for each particle.
    Vectors(Vec<[f32; 3]>),
}

/// All channels of the particles.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Channels {
    list: Vec<Channel>,
}

impl Channels {
    /// All, in the order in which they were declared.
    pub fn iter(&self) -> impl Iterator<Item = &Channel> {
        self.list.iter()
    }

    /// All, to be changed.
    pub fn iter_mut(&mut self) -> impl Iterator<Item = &mut Channel> {
        self.list.iter_mut()
    }

    /// The channel of this name, if there is one.
    pub fn get(&self, name: &str) -> Option<&Channel> {
        self.list.iter().find(|channel| channel.declaration.name == name)
    }

    /// The numbers of a channel that was declared with one.
    ///
    /// # Panics
    /// If there is no such channel, or it is one of vectors: a force that asks for what it didn't declare.
    pub fn numbers_mut(&mut self, name: &str) -> &mut [f32] {
        match &mut self.declared(name).values {
            ChannelValues::Numbers(numbers) => numbers,
            ChannelValues::Vectors(_) => panic!("channel `{name}` was declared with a vector"),
        }
    }

    /// The vectors of a channel that was declared with one.
    ///
    /// # Panics
    /// If there is no such channel, or it is one of numbers: a force that asks for what it didn't declare.
    pub fn vectors_mut(&mut self, name: &str) -> &mut [[f32; 3]] {
        match &mut self.declared(name).values {
            ChannelValues::Vectors(vectors) => vectors,
            ChannelValues::Numbers(_) => panic!("channel `{name}` was declared with a number"),
        }
    }

    fn declared(&mut self, name: &str) -> &mut Channel {
        let found = self.list.iter_mut().find(|channel| channel.declaration.name == name);
        found.unwrap_or_else(|| panic!("no force has declared a channel `{name}`"))
    }

    /// Adds a channel for `count` particles; one that is there already keeps its values.
    ///
    /// # Errors
    /// A name that another declaration has.
    pub(crate) fn declare(&mut self, declaration: ChannelDeclaration, count: usize) -> Result<(), String> {
        match self.get(declaration.name) {
            Some(channel) if channel.declaration == declaration => Ok(()),
            Some(_) => Err(format!("there are two channels `{}`", declaration.name)),
            None => {
                let values = match declaration.initial {
                    Initial::Number(_) => ChannelValues::Numbers(Vec::new()),
                    Initial::Vector(_) => ChannelValues::Vectors(Vec::new()),
                };
                self.list.push(Channel { declaration, values });
                self.resize(count);
                Ok(())
            }
        }
    }

    /// New particles begin as the declarations say.
    pub(crate) fn resize(&mut self, count: usize) {
        for Channel { declaration, values } in &mut self.list {
            match (values, declaration.initial) {
                (ChannelValues::Numbers(numbers), Initial::Number(initial)) => numbers.resize(count, initial),
                (ChannelValues::Vectors(vectors), Initial::Vector(initial)) => vectors.resize(count, initial),
                _ => unreachable!("made by the declaration"),
            }
        }
    }

    /// Writes the channels in a new order, which may leave some particles out: old indices.
    pub(crate) fn reorder_into(&self, order: &[u32], out: &mut Channels) {
        if !out.are_those_of(self) {
            *out = self.clone();
        }
        for (channel, out) in self.list.iter().zip(&mut out.list) {
            match (&channel.values, &mut out.values) {
                (ChannelValues::Numbers(of), ChannelValues::Numbers(out)) => reorder(of, order, out),
                (ChannelValues::Vectors(of), ChannelValues::Vectors(out)) => reorder(of, order, out),
                _ => unreachable!("of one declaration"),
            }
        }
    }

    /// Whether they are declared as others are.
    pub(crate) fn are_those_of(&self, other: &Channels) -> bool {
        self.list
            .iter()
            .map(|channel| channel.declaration)
            .eq(other.list.iter().map(|other| other.declaration))
    }

    /// Whether all have this many values.
    pub(crate) fn are_of(&self, count: usize) -> bool {
        self.list.iter().all(|channel| channel.values.len() == count)
    }

    /// Bytes of a particle's values.
    pub(crate) fn bytes_of_particle(&self) -> usize {
        let of = |channel: &Channel| match channel.declaration.initial {
            Initial::Number(_) => size_of::<f32>(),
            Initial::Vector(_) => size_of::<[f32; 3]>(),
        };
        self.list.iter().map(of).sum()
    }
}

impl ChannelValues {
    /// How many there are.
    pub fn len(&self) -> usize {
        match self {
            ChannelValues::Numbers(numbers) => numbers.len(),
            ChannelValues::Vectors(vectors) => vectors.len(),
        }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// Values in a new order, which may leave some out: old indices.
pub(crate) fn reorder<T: Copy + Send + Sync>(values: &[T], order: &[u32], out: &mut Vec<T>) {
    order.par_iter().with_min_len(1024).map(|&old| values[old as usize]).collect_into_vec(out);
}

#[cfg(test)]
mod tests {
    use super::*;

    const AGE: ChannelDeclaration =
        ChannelDeclaration { name: "age", initial: Initial::Number(2.0), in_frames: true };

    #[test]
    fn values_go_with_the_particles() {
        let mut channels = Channels::default();
        channels.declare(AGE, 2).unwrap();
        channels.numbers_mut("age").copy_from_slice(&[5.0, 6.0]);
        channels.resize(4);
        let mut out = Channels::default();
        for _ in 0..2 {
            channels.reorder_into(&[3, 1, 0], &mut out);
            assert_eq!(out.numbers_mut("age"), [2.0, 6.0, 5.0]);
        }
    }

    #[test]
    fn a_name_has_one_meaning() {
        let mut channels = Channels::default();
        channels.declare(AGE, 3).unwrap();
        channels.numbers_mut("age")[0] = 7.0;
        channels.declare(AGE, 3).unwrap();
        assert_eq!(channels.numbers_mut("age")[0], 7.0, "what was there is kept");
        let other = ChannelDeclaration { initial: Initial::Vector([0.0; 3]), ..AGE };
        assert!(channels.declare(other, 3).is_err());
    }
}
