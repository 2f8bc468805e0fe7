//! NetCDF-3 files, written by the definition of the format.

/// A classic file (CDF-1) without records.
#[derive(Debug, Default)]
pub struct NetCdf {
    pub dimensions: Vec<(&'static str, usize)>,
    pub variables: Vec<Variable>,
}

#[derive(Debug, Clone)]
pub struct Variable {
    pub name: &'static str,
    /// Places in [`NetCdf::dimensions`].
    pub dimensions: Vec<usize>,
    pub texts: Vec<(&'static str, &'static str)>,
    /// Names, types and bytes.
    numbers: Vec<(&'static str, usize, Vec<u8>)>,
    pub values: Values,
}

#[derive(Debug, Clone)]
pub enum Values {
    Double(Vec<f64>),
    Float(Vec<f32>),
    Int(Vec<i32>),
    Short(Vec<i16>),
}

impl Variable {
    pub fn new(name: &'static str, dimensions: &[usize], values: Values) -> Variable {
        Variable {
            name,
            dimensions: dimensions.to_vec(),
            texts: Vec::new(),
            numbers: Vec::new(),
            values,
        }
    }

    /// The same with a text.
    pub fn text(mut self, name: &'static str, text: &'static str) -> Variable {
        self.texts.push((name, text));
        self
    }

    /// The same with a number.
    pub fn number(mut self, name: &'static str, number: f64) -> Variable {
        self.numbers.push((name, 6, number.to_be_bytes().to_vec()));
        self
    }

    /// The same with an integer.
    pub fn integer(mut self, name: &'static str, number: i32) -> Variable {
        self.numbers.push((name, 4, number.to_be_bytes().to_vec()));
        self
    }
}

impl Values {
    fn bytes(&self) -> (u32, Vec<u8>) {
        let (code, mut bytes): (u32, Vec<u8>) = match self {
            Values::Double(values) => (6, values.iter().flat_map(|v| v.to_be_bytes()).collect()),
            Values::Float(values) => (5, values.iter().flat_map(|v| v.to_be_bytes()).collect()),
            Values::Int(values) => (4, values.iter().flat_map(|v| v.to_be_bytes()).collect()),
            Values::Short(values) => (3, values.iter().flat_map(|v| v.to_be_bytes()).collect()),
        };
        bytes.resize(bytes.len().next_multiple_of(4), 0);
        (code, bytes)
    }
}

impl NetCdf {
    /// The bytes of the file.
    pub fn bytes(&self) -> Vec<u8> {
        let sizes: Vec<usize> = self
            .variables
            .iter()
            .map(|v| v.values.bytes().1.len())
            .collect();
        let header = self.header(&vec![0; sizes.len()]).len();
        let mut begins = Vec::new();
        let mut at = header;
        for size in &sizes {
            begins.push(at);
            at += size;
        }
        let mut bytes = self.header(&begins);
        for variable in &self.variables {
            bytes.extend(variable.values.bytes().1);
        }
        bytes
    }

    fn header(&self, begins: &[usize]) -> Vec<u8> {
        let mut out = b"CDF\x01".to_vec();
        put(&mut out, 0);
        put(&mut out, 0x0a);
        put(&mut out, self.dimensions.len());
        for (name, len) in &self.dimensions {
            put_name(&mut out, name);
            put(&mut out, *len);
        }
        // No attributes of the file.
        put(&mut out, 0);
        put(&mut out, 0);
        put(&mut out, 0x0b);
        put(&mut out, self.variables.len());
        for (variable, begin) in self.variables.iter().zip(begins) {
            put_name(&mut out, variable.name);
            put(&mut out, variable.dimensions.len());
            for &d in &variable.dimensions {
                put(&mut out, d);
            }
            let count = variable.texts.len() + variable.numbers.len();
            put(&mut out, if count == 0 { 0 } else { 0x0c });
            put(&mut out, count);
            for (name, text) in &variable.texts {
                put_name(&mut out, name);
                put(&mut out, 2);
                put_name(&mut out, text);
            }
            for (name, code, number) in &variable.numbers {
                put_name(&mut out, name);
                put(&mut out, *code);
                put(&mut out, 1);
                out.extend(number);
            }
            let (code, bytes) = variable.values.bytes();
            put(&mut out, code as usize);
            put(&mut out, bytes.len());
            put(&mut out, *begin);
        }
        out
    }
}

fn put(out: &mut Vec<u8>, number: usize) {
    out.extend((number as u32).to_be_bytes());
}

fn put_name(out: &mut Vec<u8>, name: &str) {
    put(out, name.len());
    out.extend(name.bytes());
    out.resize(out.len().next_multiple_of(4), 0);
}
