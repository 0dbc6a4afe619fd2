//! What a simulation leaves: frames, statistics, pictures, check-points.
