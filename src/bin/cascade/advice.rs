//! What the user can do about errors and warnings, with the options that mend them.

use std::io::ErrorKind;
use std::path::Path;

use wavecascade::Error;
use wavecascade::chain::RunWarning;
use wavecascade::error::{
    CoordinateKind, ForeignFormat, FormatError, InputFault, KeyPlace, Problem, ScanFault,
    SceneFault,
};
use wavecascade::sheet::Warning;

use crate::examples::names;

/// Of an error, where there is something to do.
pub fn of_error(error: &Error) -> Option<String> {
    let advice = match error {
        Error::Input { fault, .. } => return of_input(fault),
        Error::Scan { fault, .. } => return of_scan(fault),
        Error::Scene { fault } => return Some(of_scene(fault)),
        Error::Read { source, path, .. } if source.kind() == ErrorKind::NotFound => {
            return Some(of_missing(path));
        }
        Error::NonFinite { .. } => {
            "state what to do with gaps: `--gaps interpolate` fills them along time, \
             `--gaps mask` gives them no weight; averages of segments (`cascade spectrum`) can leave out those \
             that hold them with `--gaps leave-out`"
        }
        Error::Changed { .. } => {
            "repeat the command once nothing writes to the file, or on a copy (`--read copy`)"
        }
        Error::Exists { .. } => "name another place, or add `--force` to replace it",
        Error::Busy { .. } => "wait for it, or compute parts in directories of their own",
        Error::Damaged { .. } => "begin anew elsewhere",
        Error::Paused { .. } => "the same command goes on from there",
        Error::OutputInUse { .. } => "name another place",
        Error::BelowNoise { .. } => {
            "average repeated records, record longer before the impact, or state which channels \
             are too noisy to use as missing; an offset of the velocity grows with time, so a \
             shorter record may do"
        }
        Error::Memory { .. } => {
            "raise `--memory`, choose fewer sites or times, shorter segments or fewer tapers, or ask for less: \
             `--threads 1`, `--only`, `--equal-weights`"
        }
        Error::Refused { .. } => {
            "lower `--memory`, choose fewer sites or times, use `--threads 1`, or raise the limit \
             (`ulimit -v`, that of the container)"
        }
        Error::Range { .. } => {
            "leave the large samples out with `--times`, or ask for spectra along time alone: `--only temporal`"
        }
        Error::Parseval { .. } => {
            "repeat it with `--precision f64`; if it stays, check the largest and smallest samples of the field"
        }
        Error::Write { source, .. } => match source.kind() {
            ErrorKind::FileTooLarge => "raise the allowed size of files: `ulimit -f unlimited`",
            ErrorKind::QuotaExceeded | ErrorKind::StorageFull => {
                "free some space, or write elsewhere with `--out`"
            }
            _ => "write elsewhere with `--out`",
        },
        _ => return None,
    };
    Some(advice.into())
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
        OtherName { .. } | NoPosition { .. } => {
            "list the positions in a table with the columns file and position: `--position-from table.csv`"
        }
        SeveralPositions {
            place: "the names", ..
        } => "name the letters before the position, such as `--position-from name:x`",
        SeveralPositions { .. } => "name the position, such as `--position-from header:x`",
        NotInTable { .. } => "add a row for it, with its path as typed or its last part",
        EqualPositions { .. } => "leave one out, or take their mean: `--equal-positions average`",
        Channels { .. } => {
            "name the record with `--channel` (a name, or a number from 0) or `--variable`; several files \
             with a field each are analyzed without `--position-from`"
        }
        NoSuchChannel { .. } => "name one of them, or count them from 0",
        Unlike { .. } => {
            "leave the file out, or write it anew with the step and unit of the others"
        }
        Fraction { .. } => {
            "interpolate the records, `--resample cubic`, or allow more, `--jitter 5%`"
        }
        NoCommonTime { .. } => "leave one of the two files out, or check the times of both",
        Uncorrelated { .. } => "check file and channel; `--least-correlation` accepts a weaker one",
        NoReference => "name another `--reference`, or leave the file out",
        _ => return None,
    };
    Some(advice.into())
}

const DAMAGED: &str =
    "the file was damaged or cut short while written or copied; copy or write it again";
const CONVERT: &str = "convert it with `numpy.save(\"field.npy\", array)`";

fn of_input(fault: &InputFault) -> Option<String> {
    use InputFault::*;
    let advice = match fault {
        Empty | NoRows | NoSamples { .. } => {
            "check that the program which wrote the file had finished"
        }
        Curve { .. } => "write one row a point: abscissa, value, standard error if known",
        NotAFile { .. } => "name a file inside it, or write the samples to a file first",
        ForeignFormat { format } => conversion(*format),
        UnknownFormat { found } if found.contains("\"toml\"") => {
            "a scene is run first: `cascade simulate SCENE.toml`, then `cascade analyze SCENE.npz`; beside a field, name the field"
        }
        UnknownFormat { .. } => CONVERT,
        NoRun { .. } | RunShape { .. } | RunScene { .. } | RunReport { .. } => {
            "make it anew with `cascade simulate`"
        }
        RunChanged { .. } => {
            "make it anew with `cascade simulate`; other velocities are a field, to be saved as an `.npy` of its own"
        }
        Contradiction { what, .. } => match *what {
            "sample interval" => "state the right one with `--dt` or `--rate`",
            "distance of the sites" => "state the right one with `--dx`",
            "clock" => "keep one of them; of a table, name the column with `--time-column`",
            "unit of the samples" => "state the right one with `--unit`",
            _ => "correct the file, or save the samples apart",
        },
        Factors { .. } => "correct the file, or save the samples apart",
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
                _ => DAMAGED.into(),
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
        AxisLength { axis: "time", .. } => {
            "check `--layout`, or state `--t0` and `--dt` in their place"
        }
        AxisLength { .. } => "check `--layout`, or state `--x0` and `--dx` in their place",
        UnevenAxis { found, .. } | UnevenTimes { found, .. }
            if !(*found > 0.0 && *found < f64::INFINITY) =>
        {
            "coordinates must increase: sort the samples by them, and leave one of equal ones"
        }
        UnevenAxis { .. } | UnevenTimes { .. } => {
            "interpolate to even steps with `--resample cubic`, allow more deviation (`--jitter 5%`), or \
             state `--dt` or `--dx` if the coordinates are approximate"
        }
        TooLarge { .. } | Overclaimed { .. } => DAMAGED,
        Delays { .. } => {
            "take the times that all have with `--delays align`, or state `--delays ignore`"
        }
        Delay { .. } => "interpolate the traces, `--resample cubic`, or allow more, `--jitter 10%`",
        NoCommonTime { .. } => "leave traces out: save those that overlap as a file of their own",
        LongStep { .. } => {
            "fill in missing samples as `nan`, or save both sides as fields of their own"
        }
        UnitOfAxis { .. } => {
            "state numbers without a unit, or the axis's with `--time-unit` or `--space-unit`"
        }
        FirstColumn {
            coordinates: CoordinateKind::Times,
            ..
        } => "state `--time-column 0` if it holds times, `--time-column none` if it holds samples",
        FirstColumn { .. } => {
            "name positions `x` in a header; state `--time-column none` for samples"
        }
        NoColumns => "state `--time-column none` if the one column holds samples",
        Encoding { .. } => "save the table as plain UTF-8 text",
        Ragged { .. } => "give every row the same number of cells; an empty cell is a gap",
        Cell { line: 1, .. } => {
            "state `--header present` if it is a header; an empty cell is a gap"
        }
        Cell { .. } => "write numbers with a decimal point; an empty cell or `nan` is a gap",
        RowLength { .. } => "check the line ends and quotes, or save the table as `.npy`",
        NoSuchColumn { .. } => "name one of the columns, or count them from 0",
        TwoSidecars { .. } => "keep one of the two",
        Sidecar { .. } => {
            "the keys are layout, dt, rate, dx, t0, x0, time_unit, space_unit, quantity, unit"
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
        ForeignFormat::Parquet => {
            "save it as CSV: `pandas.read_parquet(path).to_csv(\"field.csv\", index=False)`"
        }
        ForeignFormat::Excel => "save it as CSV",
        ForeignFormat::Gzip => "unpack it with `gunzip`",
        ForeignFormat::Zstd => "unpack it with `unzstd`",
        ForeignFormat::Wav => {
            "convert it in Python, one channel a site: `rate, v = scipy.io.wavfile.read(path); \
             numpy.save(\"field.npy\", v.astype(float))`, and state `--rate`"
        }
        // Formats that are read, whose name or content is of another.
        _ => "the file is damaged, or its name is of another format: rename it, or write it again",
    }
}

/// A finding about a run, with what to do about it.
pub fn of_run(warning: &RunWarning) -> Warning {
    let advice = match warning {
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
    };
    Warning::new(warning.message(), advice)
}
