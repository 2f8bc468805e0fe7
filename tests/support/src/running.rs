//! Programs that run while a test does something to them.

use std::fs;
use std::process::{Child, Command, Output, Stdio};
use std::time::Duration;

use crate::place::{NO_CONFIGURATION, Place, program};

/// A field of zeros but for one sample, without its blocks on the disk.
pub fn sparse(place: &Place, name: &str, n_times: u64, n_sites: u64) {
    use std::io::{Seek, SeekFrom, Write};
    let mut header =
        format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({n_times}, {n_sites}), }}");
    while (header.len() + 11) % 64 != 0 {
        header.push(' ');
    }
    header.push('\n');
    let mut file = fs::File::create(place.path(name)).unwrap();
    file.write_all(b"\x93NUMPY\x01\x00").unwrap();
    file.write_all(&(header.len() as u16).to_le_bytes())
        .unwrap();
    file.write_all(header.as_bytes()).unwrap();
    file.write_all(&1f64.to_le_bytes()).unwrap();
    let end = 10 + header.len() as u64 + 8 * n_times * n_sites;
    file.seek(SeekFrom::Start(end - 8)).unwrap();
    file.write_all(&1f64.to_le_bytes()).unwrap();
}

/// Starts the program.
pub fn start(place: &Place, words: &[&str]) -> Child {
    Command::new(program())
        .envs(NO_CONFIGURATION)
        .args(words)
        .current_dir(place.folder())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap()
}

/// What a script comes to, of which `$1` is the program.
pub fn shell(place: &Place, script: &str) -> Output {
    let mut command = Command::new("sh");
    command.envs(NO_CONFIGURATION).args(["-c", script, "sh"]);
    command.arg(program()).current_dir(place.folder());
    command.output().unwrap()
}

/// Sends a signal, by its name without SIG.
pub fn signal(child: &Child, name: &str) {
    let sent = Command::new("kill")
        .args(["-s", name, &child.id().to_string()])
        .status();
    assert!(sent.unwrap().success());
}

/// Name of the result that is being written.
pub fn partial(place: &Place) -> Option<String> {
    place
        .names()
        .into_iter()
        .find(|name| name.starts_with(".cascade-partial-") && !name.ends_with(".lock"))
}

/// Waits until something is seen while the program runs.
pub fn wait_for(child: &mut Child, mut seen: impl FnMut() -> bool) {
    while !seen() {
        assert!(child.try_wait().unwrap().is_none(), "it ended too soon");
        std::thread::sleep(Duration::from_millis(2));
    }
}

/// Waits for a process, and returns with its output the largest memory that it had resident.
#[cfg(target_os = "linux")]
pub fn peak(mut child: Child) -> (Output, u64) {
    let status = format!("/proc/{}/status", child.id());
    let mut peak = 0;
    while child.try_wait().unwrap().is_none() {
        let said = fs::read_to_string(&status).unwrap_or_default();
        let line = said.lines().find_map(|line| line.strip_prefix("VmHWM:"));
        let kib = line.and_then(|rest| rest.trim().strip_suffix(" kB"));
        peak = kib.map_or(peak, |kib| 1024 * kib.parse::<u64>().unwrap());
        std::thread::sleep(Duration::from_millis(2));
    }
    (child.wait_with_output().unwrap(), peak)
}
