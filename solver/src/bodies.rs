//! Bodies: what the fluid touches, at rest, moved by a script or by forces.
