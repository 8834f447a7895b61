//! Tells the linker how the image is laid out.

use std::env;

fn main() {
    println!("cargo::rerun-if-changed=mps2-an386.ld");
    if env::var("CARGO_CFG_TARGET_OS").as_deref() != Ok("none") {
        return;
    }
    let package = env::var("CARGO_MANIFEST_DIR").expect("cargo sets it");
    println!("cargo::rustc-link-arg-bins=-T{package}/mps2-an386.ld");
    // no page alignment of the sections: it would only pad the image
    println!("cargo::rustc-link-arg-bins=--nmagic");
}
