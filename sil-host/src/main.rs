//! The `sil` command.
fn main() {}
