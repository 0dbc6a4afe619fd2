//! Experiments with the solver: those whose answer is known, and those of the papers.

pub mod reproduce;
pub mod validation;
