// The program's own source: `crate::args` and its neighbours are the judges of options here, too. It is included, not named
// as the path of the library, so that a source distribution has a library in this folder.
include!("../../src/bin/cascade/main.rs");
