//! Fields from files: formats, conclusions, hostile input.

mod cases;
mod formats;
mod hostile;
mod hostile_npz;
mod hostile_tables;
mod inputs;
mod labelled;
mod meanings;
mod random;
mod resample;
mod scans;
mod tables;
mod written;
