//! The textual header: 40 lines of 80 characters.

/// Printable ASCII of each EBCDIC code (code page 037), a blank for others.
const EBCDIC: [&[u8; 32]; 8] = [
    b"                                ",
    b"                                ",
    b"           .<(+|&         !$*); ",
    b"-/         ,%_>?         `:#@'=\"",
    b" abcdefghi       jklmnopqr      ",
    b" ~stuvwxyz      ^         []    ",
    b"{ABCDEFGHI      }JKLMNOPQR      ",
    b"\\ STUVWXYZ      0123456789      ",
];

/// The lines without the blanks behind them.
pub(super) fn decode(header: &[u8]) -> String {
    let count = |code: u8| header.iter().filter(|&&byte| byte == code).count();
    // Blanks are by far the most frequent: 0x40 in EBCDIC, 0x20 in ASCII.
    let is_ebcdic = count(0x40) > count(0x20);
    let character = |&byte: &u8| match byte {
        _ if is_ebcdic => char::from(EBCDIC[usize::from(byte / 32)][usize::from(byte % 32)]),
        b' '..=b'~' => char::from(byte),
        _ => ' ',
    };
    let lines = header.chunks(80).map(|line| {
        let line: String = line.iter().map(character).collect();
        line.trim_end().to_owned()
    });
    lines.collect::<Vec<_>>().join("\n").trim_end().to_owned()
}
