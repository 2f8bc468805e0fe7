//! Paints figures as PDF: lines and letters as vectors, text selectable in an embedded part of the
//! font, maps as images. The same figure gives the same bytes.

use std::collections::{BTreeMap, BTreeSet};

use miniz_oxide::deflate::compress_to_vec_zlib;
use pdf_writer::types::{CidFontType, FontFlags, SystemInfo, UnicodeCmap};
use pdf_writer::{Content, Filter, Finish, Name, Pdf as Document, Ref, Str, TextStr};
use plotters_backend::BackendColor;
use plotters_backend::text_anchor::HPos;
use subsetter::GlyphRemapper;

use super::font;
use super::painter::{Brush, Lettering, Outline, Painter, Point, Raster};
use super::scene::Rect;
use super::style::PageUnits;

/// Six letters that mark a part of a font, and its name.
const FONT: &[u8] = b"CSCADE+DejaVuSans";
const CHARACTERS: SystemInfo = SystemInfo {
    registry: Str(b"Adobe"),
    ordering: Str(b"Identity"),
    supplement: 0,
};
const COMPRESSION: u8 = 6;
/// Reach of a quarter circle's control points, over the radius.
const ROUND: f64 = 0.552_285;

/// A colour with its opacity, of 255.
#[derive(Debug, Clone, Copy)]
struct Ink {
    rgb: [u8; 3],
    alpha: u8,
}

impl From<BackendColor> for Ink {
    fn from(BackendColor { alpha, rgb }: BackendColor) -> Self {
        Ink {
            rgb: rgb.into(),
            alpha: (255.0 * alpha).round() as u8,
        }
    }
}

/// A shape or a text as it is to be written.
#[derive(Debug)]
enum Mark {
    Path {
        /// Moves start a part; all others are lines, or with three points curves.
        steps: Vec<Vec<Point>>,
        /// Of a stroke.
        width: Option<f64>,
        color: Ink,
    },
    Text {
        /// Two bytes a glyph.
        glyphs: Vec<u8>,
        size: f64,
        matrix: [f64; 6],
        color: Ink,
    },
    Image {
        at: Rect,
        index: usize,
    },
}

#[derive(Debug)]
struct Picture {
    columns: usize,
    rows: usize,
    /// Red, green, blue, compressed.
    samples: Vec<u8>,
}

/// A figure as a PDF document of one page.
#[derive(Debug)]
pub(super) struct Pdf {
    title: String,
    size: (f64, f64),
    /// Points of a unit.
    points: f64,
    marks: Vec<Mark>,
    pictures: Vec<Picture>,
    glyphs: GlyphRemapper,
    /// Characters by their glyph in the file, with their advance over the em.
    letters: BTreeMap<u16, (char, f64)>,
}

impl Pdf {
    pub fn new(title: &str, size: (f64, f64), page: &PageUnits) -> Self {
        Pdf {
            title: title.into(),
            size,
            points: page.points,
            marks: Vec::new(),
            pictures: Vec::new(),
            glyphs: GlyphRemapper::new(),
            letters: BTreeMap::new(),
        }
    }
}

impl Painter for Pdf {
    fn shape(&mut self, shape: &Outline, brush: Brush, color: BackendColor) {
        let width = match brush {
            Brush::Fill => None,
            Brush::Stroke(width) => Some(width),
        };
        let steps = match shape {
            Outline::Path(points) => points.iter().map(|point| vec![*point]).collect(),
            Outline::Rect(rect) => corners(rect),
            Outline::Circle { center, radius } => circle(*center, *radius),
        };
        if !steps.is_empty() {
            self.marks.push(Mark::Path {
                steps,
                width,
                color: color.into(),
            });
        }
    }

    fn text(&mut self, text: &str, at: Point, lettering: &Lettering) -> Result<(), String> {
        let size = lettering.size;
        let start = match lettering.anchor.h_pos {
            HPos::Left => 0.0,
            HPos::Center => -font::width(text, size) / 2.0,
            HPos::Right => -font::width(text, size),
        };
        let down = font::baseline(lettering.anchor.v_pos, size);
        let (sin, cos) = match lettering.degrees() {
            90 => (1.0, 0.0),
            180 => (0.0, -1.0),
            -90 => (-1.0, 0.0),
            _ => (0.0, 1.0),
        };
        let mut glyphs = Vec::with_capacity(2 * text.len());
        for letter in text.chars() {
            let (glyph, advance) = font::letter(letter)?;
            let glyph = self.glyphs.remap(glyph);
            self.letters.entry(glyph).or_insert((letter, advance));
            glyphs.extend(glyph.to_be_bytes());
        }
        let place = (
            at.0 + start * cos - down * sin,
            at.1 + start * sin + down * cos,
        );
        self.marks.push(Mark::Text {
            glyphs,
            size,
            matrix: [cos, sin, sin, -cos, place.0, place.1],
            color: lettering.color.into(),
        });
        Ok(())
    }

    fn image(&mut self, at: &Rect, raster: &Raster) -> Result<(), String> {
        let cells = (0..raster.rows).flat_map(|row| (0..raster.columns).map(move |c| (row, c)));
        let samples: Vec<u8> = cells
            .flat_map(|(row, column)| raster.color(row, column))
            .collect();
        self.marks.push(Mark::Image {
            at: *at,
            index: self.pictures.len(),
        });
        self.pictures.push(Picture {
            columns: raster.columns,
            rows: raster.rows,
            samples: compress_to_vec_zlib(&samples, COMPRESSION),
        });
        Ok(())
    }

    fn encode(&self) -> Result<Vec<u8>, String> {
        let refs = Refs::default();
        let mut pdf = Document::new();
        pdf.catalog(refs.catalog).pages(refs.pages);
        pdf.document_info(refs.info).title(TextStr(&self.title));
        pdf.pages(refs.pages).kids([refs.page]).count(1);
        self.write_page(&mut pdf, &refs);
        let content = compress_to_vec_zlib(&self.content(), COMPRESSION);
        let mut stream = pdf.stream(refs.content, &content);
        stream.filter(Filter::FlateDecode);
        stream.finish();
        for (index, picture) in self.pictures.iter().enumerate() {
            let mut image = pdf.image_xobject(refs.picture(index), &picture.samples);
            image.filter(Filter::FlateDecode);
            image.width(picture.columns as i32);
            image.height(picture.rows as i32);
            image.color_space().device_rgb();
            image.bits_per_component(8);
        }
        if !self.letters.is_empty() {
            self.write_font(&mut pdf, &refs)?;
        }
        Ok(pdf.finish())
    }
}

/// Objects of the document.
struct Refs {
    catalog: Ref,
    info: Ref,
    pages: Ref,
    page: Ref,
    content: Ref,
    font: Ref,
    cid_font: Ref,
    descriptor: Ref,
    font_file: Ref,
    cmap: Ref,
}

impl Default for Refs {
    fn default() -> Self {
        Refs {
            catalog: Ref::new(1),
            info: Ref::new(2),
            pages: Ref::new(3),
            page: Ref::new(4),
            content: Ref::new(5),
            font: Ref::new(6),
            cid_font: Ref::new(7),
            descriptor: Ref::new(8),
            font_file: Ref::new(9),
            cmap: Ref::new(10),
        }
    }
}

impl Refs {
    fn picture(&self, index: usize) -> Ref {
        Ref::new(11 + index as i32)
    }
}

fn picture_name(index: usize) -> String {
    format!("Map{index}")
}

fn opacity_name(alpha: u8) -> String {
    format!("Opacity{alpha}")
}

impl Pdf {
    fn write_page(&self, pdf: &mut Document, refs: &Refs) {
        let side = |units: f64| (units * self.points) as f32;
        let (width, height) = (side(self.size.0), side(self.size.1));
        let mut page = pdf.page(refs.page);
        page.media_box(pdf_writer::Rect::new(0.0, 0.0, width, height));
        page.parent(refs.pages);
        page.contents(refs.content);
        let mut resources = page.resources();
        if !self.letters.is_empty() {
            resources.fonts().pair(Name(b"Sans"), refs.font);
        }
        let mut pictures = resources.x_objects();
        for index in 0..self.pictures.len() {
            let name = picture_name(index);
            pictures.pair(Name(name.as_bytes()), refs.picture(index));
        }
        pictures.finish();
        let mut states = resources.ext_g_states();
        for alpha in self.opacities() {
            let name = opacity_name(alpha);
            let share = f32::from(alpha) / 255.0;
            let mut state = states
                .insert(Name(name.as_bytes()))
                .start::<pdf_writer::writers::ExtGraphicsState>();
            state.non_stroking_alpha(share).stroking_alpha(share);
        }
    }

    /// All opacities drawn with, if any but full.
    fn opacities(&self) -> BTreeSet<u8> {
        let colors = self.marks.iter().filter_map(|mark| match mark {
            Mark::Path { color, .. } | Mark::Text { color, .. } => Some(color.alpha),
            Mark::Image { .. } => None,
        });
        let all: BTreeSet<u8> = colors.chain([255]).collect();
        match all.len() {
            1 => BTreeSet::new(),
            _ => all,
        }
    }

    fn content(&self) -> Vec<u8> {
        let mut content = Content::new();
        let points = self.points as f32;
        let height = (self.size.1 * self.points) as f32;
        // Units of the layout, y downwards.
        content.transform([points, 0.0, 0.0, -points, 0.0, height]);
        content.set_line_join(pdf_writer::types::LineJoinStyle::BevelJoin);
        let with_opacity = !self.opacities().is_empty();
        for mark in &self.marks {
            if let (true, Mark::Path { color, .. } | Mark::Text { color, .. }) =
                (with_opacity, mark)
            {
                let name = opacity_name(color.alpha);
                content.set_parameters(Name(name.as_bytes()));
            }
            match mark {
                Mark::Path {
                    steps,
                    width,
                    color,
                } => draw_path(&mut content, steps, *width, *color),
                Mark::Text {
                    glyphs,
                    size,
                    matrix,
                    color,
                } => {
                    let [red, green, blue] = shares(*color);
                    content.set_fill_rgb(red, green, blue);
                    content.begin_text();
                    content.set_font(Name(b"Sans"), *size as f32);
                    content.set_text_matrix(matrix.map(|value| value as f32));
                    content.show(Str(glyphs));
                    content.end_text();
                }
                Mark::Image { at, index } => {
                    let [wide, high] = [at.width(), at.height()].map(|side| side as f32);
                    let name = picture_name(*index);
                    content.save_state();
                    // An image is a unit square, its first row at the top.
                    content.transform([wide, 0.0, 0.0, -high, at.left as f32, at.bottom as f32]);
                    content.x_object(Name(name.as_bytes()));
                    content.restore_state();
                }
            }
        }
        content.finish().into_vec()
    }

    fn write_font(&self, pdf: &mut Document, refs: &Refs) -> Result<(), String> {
        let part = subsetter::subset(font::BYTES, 0, &self.glyphs).map_err(|e| e.to_string())?;
        pdf.type0_font(refs.font)
            .base_font(Name(FONT))
            .encoding_predefined(Name(b"Identity-H"))
            .descendant_font(refs.cid_font)
            .to_unicode(refs.cmap);
        let mut cid_font = pdf.cid_font(refs.cid_font);
        cid_font.subtype(CidFontType::Type2);
        cid_font.base_font(Name(FONT));
        cid_font.system_info(CHARACTERS);
        cid_font.font_descriptor(refs.descriptor);
        cid_font.default_width(0.0);
        cid_font.cid_to_gid_map_predefined(Name(b"Identity"));
        let mut widths = cid_font.widths();
        for (glyph, (_, advance)) in &self.letters {
            widths.consecutive(*glyph, [(1000.0 * advance) as f32]);
        }
        widths.finish();
        cid_font.finish();
        pdf.font_descriptor(refs.descriptor)
            .name(Name(FONT))
            .flags(FontFlags::SYMBOLIC)
            .bbox(pdf_writer::Rect::new(-1021.0, -463.0, 1793.0, 1232.0))
            .italic_angle(0.0)
            .ascent(928.0)
            .descent(-236.0)
            .cap_height(729.0)
            .stem_v(80.0)
            .font_file2(refs.font_file);
        let compressed = compress_to_vec_zlib(&part, COMPRESSION);
        let mut file = pdf.stream(refs.font_file, &compressed);
        file.filter(Filter::FlateDecode);
        file.pair(Name(b"Length1"), part.len() as i32);
        file.finish();
        let mut cmap = UnicodeCmap::new(Name(b"Letters"), CHARACTERS);
        for (glyph, (letter, _)) in &self.letters {
            cmap.pair(*glyph, *letter);
        }
        pdf.cmap(refs.cmap, &cmap.finish());
        Ok(())
    }
}

fn shares(color: Ink) -> [f32; 3] {
    color.rgb.map(|part| f32::from(part) / 255.0)
}

fn draw_path(content: &mut Content, steps: &[Vec<Point>], width: Option<f64>, color: Ink) {
    let [red, green, blue] = shares(color);
    match width {
        Some(width) => content
            .set_stroke_rgb(red, green, blue)
            .set_line_width(width as f32),
        None => content.set_fill_rgb(red, green, blue),
    };
    for (index, step) in steps.iter().enumerate() {
        let points: Vec<(f32, f32)> = step.iter().map(|p| (p.0 as f32, p.1 as f32)).collect();
        match points[..] {
            [(x, y)] if index == 0 => content.move_to(x, y),
            [(x, y)] => content.line_to(x, y),
            [(a, b), (c, d), (x, y)] => content.cubic_to(a, b, c, d, x, y),
            _ => continue,
        };
    }
    match width {
        Some(_) => content.stroke(),
        None => content.fill_nonzero(),
    };
}

fn corners(rect: &Rect) -> Vec<Vec<Point>> {
    let start = (rect.left, rect.top);
    let others = [
        (rect.right, rect.top),
        (rect.right, rect.bottom),
        (rect.left, rect.bottom),
        start,
    ];
    [start]
        .into_iter()
        .chain(others)
        .map(|corner| vec![corner])
        .collect()
}

fn circle((x, y): Point, radius: f64) -> Vec<Vec<Point>> {
    let quarters = [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0), (1.0, 0.0)];
    let at = |(a, b): Point| (x + radius * a, y + radius * b);
    let mut steps = vec![vec![at(quarters[0])]];
    for pair in quarters.windows(2) {
        let (from, to) = (pair[0], pair[1]);
        steps.push(vec![
            at((from.0 + ROUND * to.0, from.1 + ROUND * to.1)),
            at((to.0 + ROUND * from.0, to.1 + ROUND * from.1)),
            at(to),
        ]);
    }
    steps
}
