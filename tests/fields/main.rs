//! Fields from files: formats, conclusions, hostile input.

mod formats;
mod hostile;
mod hostile_npz;
mod labelled;
mod random;
mod read;
mod resample;
mod scans;
mod written;
