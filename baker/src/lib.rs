//! Bakes triangle meshes into volume maps.
