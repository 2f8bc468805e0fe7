//! Pictures as text for terminals: the protocols of kitty and of iTerm, sixel, and half blocks of two colours.

use std::collections::HashMap;
use std::fmt::Write;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

type Rgb = [u8; 3];

/// How a terminal is told to draw.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Protocol {
    /// <https://sw.kovidgoyal.net/kitty/graphics-protocol>
    Kitty,
    /// <https://iterm2.com/documentation-images.html>
    Iterm,
    /// Of the terminal VT340.
    Sixel,
    /// `▀` in two colours, of 256 or of all.
    Blocks,
}

impl Protocol {
    /// What a terminal with these environment variables understands. Inside of tmux and screen, which pass on none of the
    /// others, it is blocks.
    pub fn of_terminal(variable: impl Fn(&str) -> String) -> Protocol {
        let (term, program) = (variable("TERM"), variable("TERM_PROGRAM"));
        let is = |names: &[&str], text: &str| names.iter().any(|name| text.contains(name));
        if !variable("TMUX").is_empty() || is(&["tmux", "screen"], &term) {
            Protocol::Blocks
        } else if is(&["kitty", "ghostty"], &term) || is(&["ghostty", "WezTerm"], &program) {
            Protocol::Kitty
        } else if is(&["iTerm", "vscode"], &program) || is(&["iTerm"], &variable("LC_TERMINAL")) {
            Protocol::Iterm
        } else if is(&["sixel", "foot", "mlterm", "contour"], &term) {
            Protocol::Sixel
        } else {
            Protocol::Blocks
        }
    }
}

/// Pixels that sixels have for a column of text.
const SIXEL_COLUMN: usize = 9;
/// Colours of a sixel picture.
const COLORS: usize = 256;
/// Characters of base64 in one message to kitty.
const CHUNK: usize = 4096;

/// A picture, as its file and as pixels.
pub struct Picture<'a> {
    png: &'a [u8],
    pixels: Pixels,
}

/// Row after row.
struct Pixels {
    width: usize,
    height: usize,
    rgb: Vec<Rgb>,
}

impl Picture<'_> {
    /// Decodes the PNG file of a figure, which has colours and nothing transparent.
    pub fn read(png: &[u8]) -> Result<Picture<'_>, png::DecodingError> {
        let mut decoder = png::Decoder::new(std::io::Cursor::new(png));
        decoder.set_transformations(png::Transformations::normalize_to_color8());
        let mut reader = decoder.read_info()?;
        let mut bytes = vec![0; reader.output_buffer_size().unwrap_or(0)];
        let frame = reader.next_frame(&mut bytes)?;
        let samples = frame.color_type.samples();
        let pixel = |at: &[u8]| match *at {
            [r, g, b, ..] => [r, g, b],
            _ => [255; 3],
        };
        let (width, height) = (frame.width as usize, frame.height as usize);
        let used = &bytes[..width * height * samples];
        let rgb = used.chunks_exact(samples).map(pixel).collect();
        Ok(Picture {
            png,
            pixels: Pixels { width, height, rgb },
        })
    }

    /// The text that draws it, `columns` wide.
    pub fn drawn(&self, protocol: Protocol, columns: usize) -> String {
        match protocol {
            Protocol::Kitty => kitty(self.png, columns),
            Protocol::Iterm => {
                let how = format!("inline=1;width={columns};preserveAspectRatio=1");
                format!("\x1b]1337;File={how}:{}\x07\n", STANDARD.encode(self.png))
            }
            Protocol::Sixel => sixel(&self.pixels.scaled(columns * SIXEL_COLUMN, 1)),
            Protocol::Blocks => {
                let all = std::env::var("COLORTERM");
                let all = all.is_ok_and(|text| text == "truecolor" || text == "24bit");
                blocks(&self.pixels.scaled(columns, 2), all)
            }
        }
    }
}

impl Pixels {
    /// Means over boxes, `width` pixels wide at most, of a multiple of `rows` rows.
    fn scaled(&self, width: usize, rows: usize) -> Pixels {
        let width = width.min(self.width).max(1);
        let height = (self.height * width / self.width.max(1)).max(rows) / rows * rows;
        let height = height.min(self.height.max(rows));
        let part = |i: usize, n: usize, of: usize| {
            let first = (i * of / n).min(of - 1);
            first..((i + 1) * of / n).max(first + 1)
        };
        let mean = |x: usize, y: usize| {
            let (xs, ys) = (part(x, width, self.width), part(y, height, self.height));
            let count = (xs.len() * ys.len()) as u32;
            let mut sum = [0u32; 3];
            for y in ys {
                for pixel in &self.rgb[y * self.width..][xs.clone()] {
                    for (sum, &color) in sum.iter_mut().zip(pixel) {
                        *sum += u32::from(color);
                    }
                }
            }
            sum.map(|sum| (sum / count) as u8)
        };
        let rgb = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        Pixels {
            width,
            height,
            rgb: rgb.map(|(x, y)| mean(x, y)).collect(),
        }
    }
}

fn kitty(png: &[u8], columns: usize) -> String {
    let data = STANDARD.encode(png);
    let mut text = String::new();
    let mut rest = data.as_str();
    let mut head = format!("a=T,f=100,c={columns},");
    while !rest.is_empty() {
        let (chunk, after) = rest.split_at(CHUNK.min(rest.len()));
        let more = u8::from(!after.is_empty());
        let _ = write!(text, "\x1b_G{head}m={more};{chunk}\x1b\\");
        (rest, head) = (after, String::new());
    }
    text + "\n"
}

/// Two rows of pixels a line: the upper one is the colour of the character, the lower one that of its ground.
fn blocks(pixels: &Pixels, all_colors: bool) -> String {
    let color = |[r, g, b]: Rgb| match all_colors {
        true => format!("2;{r};{g};{b}"),
        // The cube of 6 by 6 by 6 colours.
        false => {
            let [r, g, b] = [r, g, b].map(|color| (u32::from(color) * 5 + 127) / 255);
            format!("5;{}", 16 + 36 * r + 6 * g + b)
        }
    };
    let mut text = String::new();
    for pair in pixels.rgb.chunks_exact(2 * pixels.width) {
        let (upper, lower) = pair.split_at(pixels.width);
        for (&upper, &lower) in upper.iter().zip(lower) {
            let _ = write!(text, "\x1b[38;{};48;{}m▀", color(upper), color(lower));
        }
        text += "\x1b[0m\n";
    }
    text
}

/// Colours to 5 bits each, the most frequent 256 of them; others are drawn in the nearest.
fn sixel(pixels: &Pixels) -> String {
    let coarse = |pixel: &Rgb| pixel.map(|color| color >> 3);
    let mut counts: HashMap<Rgb, usize> = HashMap::new();
    for pixel in &pixels.rgb {
        *counts.entry(coarse(pixel)).or_default() += 1;
    }
    let mut palette: Vec<(usize, Rgb)> = counts.iter().map(|(&color, &n)| (n, color)).collect();
    palette.sort_unstable_by(|a, b| b.cmp(a));
    palette.truncate(COLORS);
    let distance = |a: Rgb, b: Rgb| -> i32 {
        let pairs = a.into_iter().zip(b);
        pairs
            .map(|(a, b)| (i32::from(a) - i32::from(b)).pow(2))
            .sum()
    };
    let nearest = |color: Rgb| {
        let all = palette.iter().enumerate();
        let nearest = all.min_by_key(|(_, (_, other))| distance(color, *other));
        nearest.map_or(0, |(index, _)| index)
    };
    let colors = counts.keys();
    let index: HashMap<Rgb, usize> = colors.map(|&color| (color, nearest(color))).collect();
    let all = pixels.rgb.iter();
    let indices: Vec<usize> = all.map(|pixel| index[&coarse(pixel)]).collect();

    let mut text = format!("\x1bPq\"1;1;{};{}", pixels.width, pixels.height);
    for (i, (_, color)) in palette.iter().enumerate() {
        let [r, g, b] = color.map(|color| u32::from(color) * 100 / 31);
        let _ = write!(text, "#{i};2;{r};{g};{b}");
    }
    for band in indices.chunks(6 * pixels.width) {
        let mut used = band.to_vec();
        used.sort_unstable();
        used.dedup();
        for color in used {
            let _ = write!(text, "#{color}");
            let bits = |x: usize| {
                let rows = band[x..].iter().step_by(pixels.width).enumerate();
                let set = rows.filter(|&(_, &index)| index == color);
                set.fold(0u8, |bits, (row, _)| bits | 1 << row)
            };
            let mut x = 0;
            while x < pixels.width {
                let first = bits(x);
                let run = (x..pixels.width).take_while(|&x| bits(x) == first).count();
                let sixel = char::from(b'?' + first);
                let _ = match run {
                    1..=3 => write!(text, "{}", sixel.to_string().repeat(run)),
                    _ => write!(text, "!{run}{sixel}"),
                };
                x += run;
            }
            text.push('$');
        }
        text.push('-');
    }
    text + "\x1b\\\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    const RED: Rgb = [255, 0, 0];
    const BLUE: Rgb = [0, 0, 255];

    /// Red above blue, `width` pixels wide.
    fn flag(width: usize) -> Pixels {
        let rgb = [vec![RED; width], vec![BLUE; width]].concat();
        Pixels {
            width,
            height: 2,
            rgb,
        }
    }

    fn file(pixels: &Pixels) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, pixels.width as u32, pixels.height as u32);
        encoder.set_color(png::ColorType::Rgb);
        let mut writer = encoder.write_header().unwrap();
        writer.write_image_data(pixels.rgb.as_flattened()).unwrap();
        writer.finish().unwrap();
        bytes
    }

    #[test]
    fn val_a_picture_is_read_as_it_was_written() {
        let bytes = file(&flag(3));
        let read = Picture::read(&bytes).unwrap();
        assert_eq!((read.pixels.width, read.pixels.height), (3, 2));
        assert_eq!(read.pixels.rgb, flag(3).rgb);
        assert!(Picture::read(&bytes[..20]).is_err());
    }

    #[test]
    fn val_blocks_have_the_upper_row_in_front_of_the_lower() {
        let drawn = blocks(&flag(1), true);
        assert_eq!(drawn, "\x1b[38;2;255;0;0;48;2;0;0;255m▀\x1b[0m\n");
        // 16 + 36 * 5 and 16 + 5 of the cube.
        assert_eq!(blocks(&flag(1), false), "\x1b[38;5;196;48;5;21m▀\x1b[0m\n");
        let wide = flag(64).scaled(8, 2);
        assert_eq!((wide.width, wide.height), (8, 2));
        assert_eq!(wide.rgb, flag(8).rgb);
    }

    #[test]
    fn val_sixels_are_columns_of_bits_in_runs() {
        // Row 0 is bit 0, row 1 bit 1: `@` and `A`, five times each.
        let drawn = sixel(&flag(5));
        let head = "\x1bPq\"1;1;5;2#0;2;100;0;0#1;2;0;0;100";
        assert_eq!(drawn, format!("{head}#0!5@$#1!5A$-\x1b\\\n"));
    }

    #[test]
    fn val_messages_to_kitty_are_the_file_in_parts() {
        let bytes: Vec<u8> = (0..7000).map(|n| (n * n % 251) as u8).collect();
        let drawn = kitty(&bytes, 80);
        let parts = drawn.trim_end().split_terminator("\x1b\\");
        let (heads, data): (Vec<&str>, Vec<&str>) =
            parts.filter_map(|part| part.split_once(';')).unzip();
        let first = "\x1b_Ga=T,f=100,c=80,m=1";
        assert_eq!(heads, [first, "\x1b_Gm=1", "\x1b_Gm=0"]);
        assert_eq!(STANDARD.decode(data.concat()).unwrap(), bytes);
    }

    #[test]
    fn terminals_say_what_they_understand() {
        for (set, expected) in [
            ("TERM=xterm-kitty", Protocol::Kitty),
            ("TERM=xterm-kitty TMUX=default,1,0", Protocol::Blocks),
            ("TERM_PROGRAM=iTerm.app", Protocol::Iterm),
            ("TERM=foot", Protocol::Sixel),
            ("TERM=xterm-256color", Protocol::Blocks),
            ("", Protocol::Blocks),
        ] {
            let value = |name: &str| {
                let mut all = set.split(' ').filter_map(|one| one.split_once('='));
                all.find(|(set, _)| *set == name)
                    .map_or("", |(_, value)| value)
            };
            assert_eq!(
                Protocol::of_terminal(|name| value(name).to_owned()),
                expected,
                "{set}"
            );
        }
    }
}
