//! Tells the program by which compiler it was made, for records of its speed.

use std::process::Command;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    let rustc = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let said = Command::new(rustc).arg("--version").output();
    let version = said.map(|said| String::from_utf8_lossy(&said.stdout).trim().to_owned());
    let version = version.unwrap_or_else(|_| "rustc, version unknown".into());
    println!("cargo::rustc-env=THROUGHPUT_RUSTC={version}");
}
