//! Tables on a terminal.

use wavecascade::sheet;

use crate::terminal::{HEADING, styled, wrapped};

/// Between columns.
const GAP: &str = "  ";

/// Rows of cells below named columns. The first column and those of words are aligned to the left.
pub struct Table {
    columns: Vec<Column>,
    rows: Vec<Row>,
}

struct Column {
    /// What several neighbouring columns have in common.
    group: String,
    name: String,
    is_words: bool,
}

struct Row {
    cells: Vec<String>,
    /// A remark, which stands behind the row or below it.
    note: String,
}

impl Table {
    /// Of one column.
    pub fn new(name: &str) -> Table {
        let table = Table {
            columns: Vec::new(),
            rows: Vec::new(),
        };
        table.words(name)
    }

    /// Of a described result; columns of numbers are aligned to the right.
    pub fn of(described: &sheet::Table) -> Table {
        let begins_number = |cell: &String| {
            let first = cell.chars().find(|c| !matches!(c, '-' | '\u{2212}'));
            first.is_none_or(|c| c.is_ascii_digit())
        };
        let columns = described.head.iter().enumerate().map(|(n, name)| Column {
            group: String::new(),
            name: name.clone(),
            is_words: n == 0 || !described.rows.iter().all(|row| begins_number(&row[n])),
        });
        Table {
            columns: columns.collect(),
            rows: described
                .rows
                .iter()
                .map(|cells| Row {
                    cells: cells.clone(),
                    note: String::new(),
                })
                .collect(),
        }
    }

    /// The same with a column of numbers.
    pub fn numbers(self, name: &str) -> Table {
        self.in_group("", name)
    }

    /// The same with a column of numbers under a common heading.
    pub fn in_group(mut self, group: &str, name: &str) -> Table {
        self.columns.push(Column {
            group: group.to_owned(),
            name: name.to_owned(),
            is_words: false,
        });
        self
    }

    /// The same with a column of words.
    pub fn words(mut self, name: &str) -> Table {
        self.columns.push(Column {
            group: String::new(),
            name: name.to_owned(),
            is_words: true,
        });
        self
    }

    /// Adds a row of as many cells as there are columns.
    pub fn row(&mut self, cells: Vec<String>) {
        self.noted_row(cells, "");
    }

    pub fn noted_row(&mut self, cells: Vec<String>, note: &str) {
        self.rows.push(Row {
            cells,
            note: note.to_owned(),
        });
    }

    /// In lines of at most `width` columns where cells allow it. Where all columns do not fit, a long
    /// first column is wrapped, and the columns that are left follow in tables below, each of which
    /// begins with the first column.
    pub fn text(&self, width: usize) -> String {
        let layout = Layout::of(self, width);
        let mut text = String::new();
        for (n, block) in layout.blocks.iter().enumerate() {
            if n > 0 {
                text.push('\n');
            }
            text += &self.head(&layout, block);
            for row in &self.rows {
                let lines = layout.lines(block, |column| &row.cells[column]);
                match n + 1 == layout.blocks.len() {
                    true => text += &with_note(lines, &row.note, width),
                    false => text += &lines,
                }
            }
        }
        text
    }

    /// The names, below those of groups if there are some.
    fn head(&self, layout: &Layout, block: &[usize]) -> String {
        let names = layout.lines(block, |column| &self.columns[column].name);
        let mut groups = String::new();
        let mut n = 0;
        while n < block.len() {
            let group = &self.columns[block[n]].group;
            let same = block[n..].iter();
            let same = same.take_while(|&&column| self.columns[column].group == *group);
            let members = if group.is_empty() { 1 } else { same.count() };
            let widths = block[n..n + members]
                .iter()
                .map(|&column| layout.widths[column]);
            let width = widths.sum::<usize>() + GAP.len() * (members - 1);
            let gap = if n > 0 { GAP } else { "" };
            groups += &format!("{gap}{group:>width$}");
            n += members;
        }
        let head = [groups.trim_end(), names.trim_end()];
        let lines = head.iter().flat_map(|part| part.lines());
        lines.map(|line| styled(HEADING, line) + "\n").collect()
    }
}

/// A row with its remark: behind it where that fits, else below.
fn with_note(lines: String, note: &str, width: usize) -> String {
    if note.is_empty() {
        return lines;
    }
    let row = lines.trim_end();
    let last = row.lines().last().unwrap_or_default();
    if last.chars().count() + GAP.len() + note.chars().count() <= width {
        return format!("{row}{GAP}{note}\n");
    }
    let below = wrapped(note, width.saturating_sub(GAP.len()));
    below
        .iter()
        .fold(lines, |text, line| text + GAP + line + "\n")
}

/// How the columns of a table are set.
struct Layout {
    widths: Vec<usize>,
    is_words: Vec<bool>,
    /// Columns of each table.
    blocks: Vec<Vec<usize>>,
}

impl Layout {
    fn of(table: &Table, width: usize) -> Layout {
        let natural = |column: usize| {
            let cells = table.rows.iter().map(|row| &row.cells[column]);
            let texts = cells.chain([&table.columns[column].name]);
            texts.map(|text| text.chars().count()).max().unwrap_or(0)
        };
        let mut widths: Vec<usize> = (0..table.columns.len()).map(natural).collect();
        let all = widths.iter().sum::<usize>() + GAP.len() * (widths.len() - 1);
        if all > width {
            widths[0] = widths[0].min(2 * width / 5);
        }
        Layout {
            blocks: blocks(table, &widths, width),
            is_words: table.columns.iter().map(|column| column.is_words).collect(),
            widths,
        }
    }

    /// A row; the first cell may need several lines, of which the last has the other cells.
    fn lines<'a>(&self, block: &[usize], cell: impl Fn(usize) -> &'a String) -> String {
        let mut first = wrapped(cell(0), self.widths[0]);
        let last = first.pop().unwrap_or_default();
        let cells = block.iter().map(|&column| {
            let text = if column == 0 { &last } else { cell(column) };
            let width = self.widths[column];
            match self.is_words[column] {
                true => format!("{text:<width$}"),
                false => format!("{text:>width$}"),
            }
        });
        let line = cells.collect::<Vec<_>>().join(GAP);
        let lines = first.into_iter().chain([line.trim_end().to_owned()]);
        lines.map(|line| line + "\n").collect()
    }
}

/// Columns of each table; those of a group stay together, and empty ones are left out.
fn blocks(table: &Table, widths: &[usize], width: usize) -> Vec<Vec<usize>> {
    let mut blocks = Vec::new();
    let (mut block, mut used) = (vec![0], widths[0]);
    let mut next = 1;
    while next < widths.len() {
        let group = &table.columns[next].group;
        let is_member = |column: &&Column| !group.is_empty() && column.group == *group;
        let members = table.columns[next + 1..].iter().take_while(is_member);
        let end = next + 1 + members.count();
        let shown = (next..end).filter(|&column| widths[column] > 0);
        let needed: usize = shown.clone().map(|column| GAP.len() + widths[column]).sum();
        if used + needed > width && block.len() > 1 {
            blocks.push(std::mem::replace(&mut block, vec![0]));
            used = widths[0];
        }
        used += needed;
        block.extend(shown);
        next = end;
    }
    blocks.push(block);
    blocks
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plain(table: &Table, width: usize) -> String {
        anstream::adapter::strip_str(&table.text(width)).to_string()
    }

    #[test]
    fn columns_that_do_not_fit_follow_below() {
        let table = Table::new("order").in_group("estimate", "ratio");
        let mut table = table.in_group("estimate", "error").numbers("speed");
        table.noted_row(
            ["1", "2.5", "0.1", "3"].map(str::to_owned).to_vec(),
            "a remark",
        );
        assert_eq!(
            plain(&table, 80),
            "           estimate\norder  ratio  error  speed\n1        2.5    0.1      3  a remark\n"
        );
        assert_eq!(
            plain(&table, 20),
            "           estimate\norder  ratio  error\n1        2.5    0.1\n\norder  speed\n\
             1          3\n  a remark\n"
        );
    }
    #[test]
    fn a_long_first_column_is_wrapped_and_an_empty_one_left_out() {
        let mut table = Table::new("").numbers("first").words("");
        let row = ["share passed from low to high k", "0.25", ""];
        table.row(row.map(str::to_owned).to_vec());
        assert_eq!(
            plain(&table, 30),
            "              first\nshare passed\nfrom low to\nhigh k         0.25\n"
        );
    }
}
