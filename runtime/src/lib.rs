//! Volume maps at run time.
