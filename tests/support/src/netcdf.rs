//! NetCDF-3 files, written by the definition of the format.

/// A variable: its name, places of its dimensions, attributes, the code of its type, and its samples.
struct Variable<'a> {
    name: &'a str,
    dimensions: Vec<usize>,
    attributes: Vec<(&'a str, &'a str)>,
    code: u32,
    samples: Vec<u8>,
}

/// A classic file (CDF-1) without records, of a line: its dimensions and, behind `; ` each, its variables, as
/// `time=3 x=2; time(time) f8 0:0.5 units=ms; v(time,x) i2 [1,-9,3,4,5,6] _FillValue=-9 units=m~s-2`.
/// Samples of `f8`, `f4`, `i4` or `i2` are listed, or rise from a number by another; a blank in a text is `~`, and `3i` an integer.
pub fn netcdf(line: &str) -> Vec<u8> {
    let mut parts = line.split("; ");
    let dimensions = parts.next().unwrap().split(' ');
    let dimensions: Vec<(&str, usize)> = dimensions
        .filter_map(|word| word.split_once('='))
        .map(|(name, length)| (name, length.parse().unwrap()))
        .collect();
    let variables: Vec<Variable> = parts.map(|part| variable(part, &dimensions)).collect();
    let begin = header(&dimensions, &variables, 0).len();
    let mut bytes = header(&dimensions, &variables, begin);
    bytes.extend(variables.into_iter().flat_map(|variable| variable.samples));
    bytes
}

fn variable<'a>(part: &'a str, dimensions: &[(&str, usize)]) -> Variable<'a> {
    let words: Vec<&str> = part.split(' ').collect();
    let (name, along) = words[0].trim_end_matches(')').split_once('(').unwrap();
    let along = along.split(',').filter(|name| !name.is_empty());
    let place = |of: &str| dimensions.iter().position(|(name, _)| *name == of).unwrap();
    let along: Vec<usize> = along.map(place).collect();
    let count: usize = along.iter().map(|at| dimensions[*at].1).product();
    let number = |text: &str| text.parse::<f64>().unwrap();
    let listed = words[2].trim_matches(['[', ']']).split(',');
    let numbers: Vec<f64> = match words[2].split_once(':') {
        Some((from, step)) => {
            let of = |i: u32| number(from) + f64::from(i) * number(step);
            (0..count as u32).map(of).collect()
        }
        None => listed.map(number).collect(),
    };
    let (code, bytes): (u32, fn(f64) -> Vec<u8>) = match words[1] {
        "f8" => (6, |v| v.to_be_bytes().into()),
        "f4" => (5, |v| (v as f32).to_be_bytes().into()),
        "i4" => (4, |v| (v as i32).to_be_bytes().into()),
        _ => (3, |v| (v as i64 as i16).to_be_bytes().into()),
    };
    let mut samples: Vec<u8> = numbers.into_iter().flat_map(bytes).collect();
    samples.resize(samples.len().next_multiple_of(4), 0);
    let attributes = words[3..].iter().filter_map(|word| word.split_once('='));
    Variable {
        name,
        dimensions: along,
        attributes: attributes.collect(),
        code,
        samples,
    }
}

fn header(dimensions: &[(&str, usize)], variables: &[Variable], begin: usize) -> Vec<u8> {
    let mut out = b"CDF\x01".to_vec();
    put(&mut out, &[0, 0x0a, dimensions.len()]);
    for (name, length) in dimensions {
        put_text(&mut out, name);
        put(&mut out, &[*length]);
    }
    // No attributes of the file.
    put(&mut out, &[0, 0, 0x0b, variables.len()]);
    let mut at = begin;
    for variable in variables {
        put_text(&mut out, variable.name);
        put(&mut out, &[variable.dimensions.len()]);
        put(&mut out, &variable.dimensions);
        let count = variable.attributes.len();
        put(&mut out, &[if count == 0 { 0 } else { 0x0c }, count]);
        for (name, value) in &variable.attributes {
            put_text(&mut out, name);
            let integer = value.strip_suffix('i').unwrap_or("").parse::<i32>();
            match (integer, value.parse::<f64>()) {
                (Ok(integer), _) => {
                    put(&mut out, &[4, 1]);
                    out.extend(integer.to_be_bytes());
                }
                (_, Ok(number)) => {
                    put(&mut out, &[6, 1]);
                    out.extend(number.to_be_bytes());
                }
                _ => {
                    put(&mut out, &[2]);
                    put_text(&mut out, &value.replace('~', " "));
                }
            }
        }
        let length = variable.samples.len();
        put(&mut out, &[variable.code as usize, length, at]);
        at += length;
    }
    out
}

fn put(out: &mut Vec<u8>, numbers: &[usize]) {
    for number in numbers {
        out.extend((*number as u32).to_be_bytes());
    }
}

fn put_text(out: &mut Vec<u8>, text: &str) {
    put(out, &[text.len()]);
    out.extend(text.bytes());
    out.resize(out.len().next_multiple_of(4), 0);
}
