//! Leaves names and debug information out of the shared library: tens of megabytes in every FMU.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rustc-cdylib-link-arg=-Wl,--strip-all");
}
