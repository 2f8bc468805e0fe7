//! Bytes of a description, read value by value.

use std::fmt::Display;

use crate::{ByteOrder, Error, Options, Result};

/// Bytes and the place in them that is read next.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Cursor<'a> {
    pub bytes: &'a [u8],
    pub at: usize,
    pub order: ByteOrder,
}

impl<'a> Cursor<'a> {
    pub fn take(&mut self, len: u64, expected: &str) -> Result<&'a [u8]> {
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        let taken = usize::try_from(len).ok().and_then(|len| rest.get(..len));
        let Some(taken) = taken else {
            let found = format!("{} bytes", rest.len());
            return Err(self.damaged(format!("{expected} ({len} bytes)"), found));
        };
        self.at += taken.len();
        Ok(taken)
    }

    /// An unsigned number of `len` bytes.
    pub fn number(&mut self, len: u64, expected: &str) -> Result<u64> {
        Ok(self.order.unsigned(self.take(len, expected)?))
    }

    pub fn u32(&mut self, expected: &str) -> Result<u32> {
        Ok(self.number(4, expected)? as u32)
    }

    /// What is wrong with the bytes that are read next.
    pub fn damaged(&self, expected: impl Display, found: impl Display) -> Error {
        Error::damaged(format!("byte {}", self.at), expected, found)
    }
}

/// Memory that the description of a file takes, counted before it is taken.
#[derive(Debug)]
pub(crate) struct Budget {
    what: &'static str,
    used: u64,
    allowed: Option<u64>,
}

impl Budget {
    pub fn new(what: &'static str, options: &Options) -> Budget {
        Budget {
            what,
            used: 0,
            allowed: options.memory,
        }
    }

    pub fn take(&mut self, bytes: u64) -> Result<()> {
        self.used = self.used.saturating_add(bytes);
        match self.allowed {
            Some(allowed) if self.used > allowed => Err(Error::Memory {
                what: self.what.into(),
                needed: self.used,
                allowed,
            }),
            _ => Ok(()),
        }
    }
}

/// How a file begins, for messages.
pub(crate) fn beginning(bytes: &[u8]) -> String {
    let start = &bytes[..bytes.len().min(20)];
    let is_text = |byte: &u8| byte.is_ascii_graphic() || byte.is_ascii_whitespace();
    let kind = match start.iter().all(is_text) {
        true => "the text",
        false => "the bytes",
    };
    format!("{kind} \"{}\"", start.escape_ascii())
}
