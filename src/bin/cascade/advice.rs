//! What the user can do about errors and warnings, with the options that mend them.

use std::path::Path;

use wavecascade::Error;
use wavecascade::chain::RunWarning;
use wavecascade::error::{
    CoordinateKind, FileKind, ForeignFormat, FormatError, InputFault, KeyPlace, Problem, ScanFault,
    SceneFault,
};

use crate::examples::names;

/// Of an error, where there is something to do.
pub fn of_error(error: &Error) -> Option<String> {
    match error {
        Error::Input { fault, .. } => of_input(fault),
        Error::Scan { fault, .. } => of_scan(fault),
        Error::NonFinite { .. } => Some(
            "state what to do with gaps: `--gaps interpolate` fills them along time, \
             `--gaps mask` gives them no weight; averages of segments (`cascade spectrum`) can leave out those \
             that hold them with `--gaps leave-out`"
                .into(),
        ),
        Error::Changed { .. } => {
            Some("repeat the command once nothing writes to the file, or on a copy (`--read copy`)".into())
        }
        Error::Scene { fault } => Some(of_scene(fault)),
        Error::Exists { .. } => {
            Some("name another place, or add `--force` to replace it".into())
        }
        Error::Busy { .. } => Some("wait for it, or compute parts in directories of their own".into()),
        Error::Damaged { .. } => Some("begin anew elsewhere".into()),
        Error::Paused { .. } => Some("the same command goes on from there".into()),
        Error::OutputInUse { .. } => Some("name another place with `--out`".into()),
        Error::BelowNoise { .. } => Some(
            "average repeated records, record longer before the impact, or state which channels \
             are too noisy to use as missing; an offset of the velocity grows with time, so a \
             shorter record may do"
                .into(),
        ),
        Error::Memory { what: "the transform of eight records", .. } => Some(
            "raise `--memory`, or filter a part of the field: save fewer times".into(),
        ),
        Error::Memory { what: "the space-time spectrum of this field", .. } => Some(
            "raise `--memory`, choose fewer sites or times, shorter segments or fewer tapers, or give all tapers \
             the same weight (`--equal-weights`), which keeps one sum for all of them"
                .into(),
        ),
        Error::Memory { what: "the result of these parts", .. } => {
            Some("raise `--memory`, or merge on a machine with more".into())
        }
        Error::Memory { .. } => {
            Some("raise `--memory`, choose fewer sites or times, or ask for less: `--threads 1`, `--only`".into())
        }
        Error::Refused { .. } => Some(
            "lower `--memory`, choose fewer sites or times, use `--threads 1`, or raise the limit \
             (`ulimit -v`, that of the container)"
                .into(),
        ),
        Error::Range { .. } => Some(
            "leave the large samples out with `--times`, or ask for spectra along time alone: \
             `--only temporal`"
                .into(),
        ),
        Error::Parseval { .. } => Some(
            "repeat it with `--precision f64`; if it stays, check the largest and smallest samples \
             of the field"
                .into(),
        ),
        Error::Read { source, path, .. } if source.kind() == std::io::ErrorKind::NotFound => {
            Some(of_missing(path))
        }
        Error::Write { source, .. } if source.kind() == std::io::ErrorKind::FileTooLarge => {
            Some("raise the allowed size of files: `ulimit -f unlimited`".into())
        }
        Error::Write { source, .. } if is_disk_full(source) => {
            Some("free some space, or write elsewhere with `--out`".into())
        }
        Error::Write { .. } => Some("write elsewhere with `--out`".into()),
        _ => None,
    }
}

fn of_missing(path: &Path) -> String {
    let name = path.file_stem().unwrap_or_default();
    match names().find(|example| name == *example) {
        Some(name) => format!("`cascade examples {name}` writes it here"),
        None => "check the path; a relative one starts at the current directory".into(),
    }
}

fn of_scan(fault: &ScanFault) -> Option<String> {
    use ScanFault::*;
    let advice = match fault {
        OtherName { .. } => {
            "name files of one scan alike but for numbers, or list the positions: `--position-from table.csv` \
             with the columns file and position"
        }
        NoPosition { .. } => {
            "list the positions in a table with the columns file and position: `--position-from table.csv`"
        }
        SeveralPositions {
            place: "the names", ..
        } => "name the letters before the position, such as `--position-from name:x`",
        SeveralPositions { .. } => "name the position, such as `--position-from header:x`",
        NotInTable { .. } => "add a row for it, with its path as typed or its last part",
        EqualPositions { .. } => {
            "leave one of them out, or take their mean: `--equal-positions average`"
        }
        Channels { .. } => {
            "name the record with `--channel` (a name, or a number from 0) or `--variable`; several files \
             with a field each are analyzed without `--position-from`"
        }
        NoSuchChannel { .. } => "name one of them, or count them from 0",
        Unlike { .. } => {
            "a scan has one step and one unit: leave the file out, or write it anew like the others"
        }
        Fraction { .. } => {
            "shift the records by interpolation: `--resample cubic`; or, if the start times are not exact, \
             allow more: `--jitter 5%`"
        }
        NoCommonTime { .. } => "leave one of the two files out, or check the times of both",
        Uncorrelated { .. } => {
            "check that the file belongs to the scan and that the channel is the reference; a weaker one is \
             accepted with `--least-correlation`"
        }
        NoReference => "name another `--reference`, or leave the file out",
        _ => return None,
    };
    Some(advice.into())
}

fn of_input(fault: &InputFault) -> Option<String> {
    use InputFault::*;
    let advice = match fault {
        Empty | NoRows | NoSamples { .. } => {
            "check that the program which wrote the file had finished"
        }
        Curve { .. } => {
            "write one row for each point: abscissa, value, standard error if it is known"
        }
        NotAFile {
            found: FileKind::Directory,
        } => "name a file inside it",
        NotAFile { .. } => "write the samples to a file first; a field is read more than once",
        ForeignFormat { format } => conversion(*format),
        UnknownFormat { found } if found.contains("\"toml\"") => {
            "a scene is run first: `cascade simulate SCENE.toml`, then `cascade analyze SCENE.npz`; beside a field, name the field"
        }
        UnknownFormat { .. } | NpyMagic { .. } => {
            "convert it with `numpy.save(\"field.npy\", array)`"
        }
        NpyVersion { .. } | NpyHeader { .. } | NpyHeaderLength { .. } => {
            "write the array again with `numpy.save`"
        }
        PickledObjects => {
            "save numbers: `numpy.save(path, array.astype(float))`; pickles are never loaded"
        }
        StructuredType { .. } => "save one of its members: `numpy.save(path, array[\"name\"])`",
        ComplexType { .. } => "save its real part: `numpy.save(path, array.real)`",
        NoText { .. } | NotOneText { .. } | TextLength { .. } => {
            "save it as `numpy.array(\"text\")`"
        }
        NoRun { .. } | RunShape { .. } | RunScene { .. } | RunReport { .. } => {
            "make it anew with `cascade simulate`"
        }
        RunChanged { .. } => {
            "make it anew with `cascade simulate`; other velocities are a field, to be saved as an `.npy` of its own"
        }
        SampleType { .. } => "convert it: `numpy.save(path, array.astype(float))`",
        Dimensions { shape } if shape.is_empty() => "save an array (time, site), not one number",
        Dimensions { .. } => "save one component: an array (time, site)",
        TooLarge { .. } | Truncated { .. } => {
            "the file was cut short while written or copied; copy or write it again"
        }
        TrailingBytes { .. } => "write one array a file, or several with `numpy.savez`",
        Archive { .. }
        | MemberName { .. }
        | Deflate { .. }
        | InflatedSize { .. }
        | Checksum { .. } => {
            "the archive was damaged while written or copied; copy or write it again"
        }
        TooManyMembers { .. } => "save the field by itself",
        Contradiction {
            what: "sample interval",
            ..
        } => "state the right one with `--dt` or `--rate`",
        Contradiction {
            what: "distance of the sites",
            ..
        } => "state the right one with `--dx`",
        Contradiction { what: "clock", .. } => {
            "keep one of them; of a table, name the column with `--time-column`"
        }
        Contradiction {
            what: "unit of the samples",
            ..
        } => "state the right one with `--unit`",
        Contradiction { .. } | Factors { .. } => "correct the file, or save the samples apart",
        NotNumbers {
            way_out: Some(way_out),
            ..
        } => way_out,
        WhichVariable { .. } | NoSuchVariable { .. } | NotNumbers { .. } => {
            "name one of them with `--variable`; `cascade inspect FILE` lists what is in a file"
        }
        Container { fault } => {
            return Some(match &**fault {
                FormatError::Unsupported { way_out, .. } => way_out.clone(),
                _ => "the file was damaged or cut short while written or copied; copy or write it again"
                    .into(),
            });
        }
        NoTimes { .. } => "name an array with times and sites with `--variable`",
        NoSuchDimension { .. } => "name one of these dimensions, or count them from 0",
        FurtherDimension { dimension, .. } => {
            let name = &dimension.name;
            let value = dimension
                .range
                .as_ref()
                .map_or("#0".into(), |(first, ..)| first.to_string());
            return Some(format!(
                "state where it is taken, such as `--at {name}={value}`; `--time-dim` and \
                 `--space-dim` name the dimensions of times and sites"
            ));
        }
        NoSuchLabel { .. } => "`cascade inspect FILE` lists the dimensions with their values",
        Member { fault, .. } => return of_input(fault),
        Compression { .. } => "write it with `numpy.savez` or `numpy.savez_compressed`",
        Encrypted => "decrypt the archive first",
        AxisLength { axis: "time", .. } => {
            "check `--layout`, or state `--t0` and `--dt` to leave the coordinates unread"
        }
        AxisLength { .. } => {
            "check `--layout`, or state `--x0` and `--dx` to leave the coordinates unread"
        }
        UnevenAxis { found, .. } | UnevenTimes { found, .. }
            if !(*found > 0.0 && *found < f64::INFINITY) =>
        {
            "coordinates must increase: sort the samples by them, and leave one of equal ones"
        }
        UnevenAxis { axis: "space", .. } => {
            "interpolate to even spacing with `--resample cubic`, allow more deviation (`--jitter 5%`), or \
             state `--dx` if the coordinates are approximate"
        }
        UnevenAxis { .. } | UnevenTimes { .. } => {
            "interpolate to even steps with `--resample cubic`, allow more deviation (`--jitter 5%`), or \
             state `--dt` if the times are approximate"
        }
        Overclaimed { .. } => {
            "the file is damaged, or nearly all of the array was never written: save the part that was as an \
             array of its own"
        }
        Delays { .. } => {
            "take the times that all have in common with `--delays align`, or state `--delays ignore` if the \
             delays do not count"
        }
        Delay { .. } => {
            "shift the traces by interpolation: `--resample cubic`; or, if delays are not exact, allow more: \
             `--jitter 10%`"
        }
        NoCommonTime { .. } => "leave traces out: save those that overlap as a file of their own",
        LongStep { .. } => {
            "what happened within is not known: fill in samples that are missing, as `nan`, or save the \
             parts on both sides as fields of their own"
        }
        UnitOfAxis { .. } => {
            "state steps and origins as numbers in the unit of the axis, or the unit of the axis \
             with `--time-unit` or `--space-unit`"
        }
        FirstColumn {
            coordinates: CoordinateKind::Times,
            ..
        } => "state `--time-column 0` if it holds times, `--time-column none` if it holds samples",
        FirstColumn { .. } => {
            "name it `x` in a header if it holds positions; state `--time-column none` if it holds \
             samples"
        }
        NoColumns => "state `--time-column none` if the one column holds samples",
        Encoding { .. } => "save the table as plain UTF-8 text",
        Ragged { .. } => "give every row the same number of cells; an empty cell is a gap",
        Cell { line: 1, .. } => {
            "if the first line is a header, state `--header present`; an empty cell is a gap"
        }
        Cell { .. } => "write numbers with a decimal point; an empty cell or `nan` is a gap",
        RowLength { .. } => "check the line ends and quotes, or save the table as `.npy`",
        NoSuchColumn { .. } => "name one of the columns, or count them from 0",
        TwoSidecars { .. } => "keep one of the two",
        Sidecar { .. } => {
            "the keys are layout, dt, rate (or fs), dx, t0, x0, time_unit, space_unit, quantity and \
             unit"
        }
        SidecarLength { .. } => "keep only the settings of the field in it",
        _ => return None,
    };
    Some(advice.into())
}

fn of_scene(fault: &SceneFault) -> String {
    let advice = match (&fault.problem, &fault.place) {
        (Problem::TooLarge { .. }, _) => {
            "choose fewer `samples` or `sites`, keep less with `record`, or raise `memory`"
        }
        (Problem::Syntax { .. }, _) => "`cascade scene` prints a scene to start from",
        // Not one of its keys is at fault, but the file.
        (Problem::Value { .. }, KeyPlace::File { path, line: None }) if fault.key.is_empty() => {
            return format!(
                "`cascade scene` prints a scene to start from; is it a field, `cascade analyze {}` reads it",
                path.display()
            );
        }
        (Problem::Value { .. }, KeyPlace::Setting { source })
            if source.starts_with("values of ") =>
        {
            "write values as a list, 1,2,4, or a range: 1:10:19 (19 in equal steps), 1:10:19log, 1:10 (whole numbers)"
        }
        (Problem::Value { .. }, _) => "`cascade scene` prints all keys with what they mean",
        _ => "",
    };
    advice.into()
}

/// How a format that is not read is converted to one that is.
fn conversion(format: ForeignFormat) -> &'static str {
    match format {
        ForeignFormat::Hdf5 => {
            "convert it in Python, with its names of the arrays: `f = h5py.File(path); \
             numpy.savez(\"field.npz\", v=f[\"v\"][:], t=f[\"t\"][:], x=f[\"x\"][:])`"
        }
        ForeignFormat::Matlab => {
            "convert it in Python, with its names of the arrays: `m = scipy.io.loadmat(path); \
             numpy.savez(\"field.npz\", v=m[\"v\"], t=m[\"t\"].ravel(), x=m[\"x\"].ravel())`"
        }
        ForeignFormat::Matlab73 => {
            "convert it in Python, with its names of the arrays, whose axes it stores in reverse: \
             `f = h5py.File(path); numpy.savez(\"field.npz\", v=f[\"v\"][:].T, \
             t=f[\"t\"][:].ravel(), x=f[\"x\"][:].ravel())`"
        }
        ForeignFormat::NetCdf => {
            "convert it in Python, with its names of the arrays: `d = xarray.open_dataset(path); \
             numpy.savez(\"field.npz\", v=d[\"v\"].values, t=d[\"t\"].values, x=d[\"x\"].values)`"
        }
        ForeignFormat::Parquet => {
            "convert it in Python: `pandas.read_parquet(path).to_csv(\"field.csv\", index=False)`"
        }
        ForeignFormat::Excel => {
            "save it as CSV, or in Python: `pandas.read_excel(path).to_csv(\"field.csv\", index=False)`"
        }
        ForeignFormat::Gzip => "unpack it with `gunzip`",
        ForeignFormat::Zstd => "unpack it with `unzstd`",
        ForeignFormat::Wav => {
            "convert it in Python, one channel a site: `rate, v = scipy.io.wavfile.read(path); \
             numpy.save(\"field.npy\", v.astype(float))`, and state `--rate`"
        }
        _ => "convert it with `numpy.save(\"field.npy\", array)`",
    }
}

/// Of a finding about a run.
pub fn of_run(warning: &RunWarning) -> &'static str {
    match warning {
        RunWarning::Amplifies { .. } => {
            "state a `tolerance` larger than what rounding leaves, or an earlier `end_time`; where \
             single velocities are not to be had, compare energies and spectra, over several seeds"
        }
        RunWarning::Rounding { .. } => "state a larger `tolerance` or an earlier `end_time`",
        RunWarning::OutsideLaw { .. } => "give the law over a wider range, or a weaker impact",
        RunWarning::EnergyBalance { .. } => {
            "state a smaller `tolerance`, or with a method of fixed steps a smaller `step`"
        }
        _ => "",
    }
}

fn is_disk_full(error: &std::io::Error) -> bool {
    use std::io::ErrorKind::{QuotaExceeded, StorageFull};
    matches!(error.kind(), StorageFull | QuotaExceeded)
}
