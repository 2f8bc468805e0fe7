//! Tables on a terminal.

use wavecascade::sheet::Table;

use crate::terminal::{HEADING, styled, wrapped};

/// Between columns.
const GAP: &str = "  ";

/// A table in lines of at most `width` columns where cells allow it; the first column and those of words are aligned to
/// the left. Where all columns do not fit, a long first column is wrapped, and the columns that are left follow in tables
/// below, each of which begins with the first column.
pub fn text(table: &Table, width: usize) -> String {
    let natural = |column: usize| {
        let cells = table.rows.iter().map(|row| &row[column]);
        let texts = cells.chain([&table.head[column]]);
        texts.map(|text| text.chars().count()).max().unwrap_or(0)
    };
    let mut widths: Vec<usize> = (0..table.head.len()).map(natural).collect();
    let all = widths.iter().sum::<usize>() + GAP.len() * (widths.len() - 1);
    if all > width {
        widths[0] = widths[0].min(2 * width / 5);
    }
    let is_words: Vec<bool> = (0..widths.len()).map(|n| is_of_words(table, n)).collect();
    // A row; the first cell may need several lines, of which the last has the other cells.
    let set = |block: &[usize], row: &[String]| -> Vec<String> {
        let mut lines = wrapped(&row[0], widths[0]);
        let last = lines.pop().unwrap_or_default();
        let cells = block.iter().map(|&column| {
            let text = if column == 0 { &last } else { &row[column] };
            let width = widths[column];
            match is_words[column] {
                true => format!("{text:<width$}"),
                false => format!("{text:>width$}"),
            }
        });
        let line = cells.collect::<Vec<_>>().join(GAP);
        lines.push(line.trim_end().to_owned());
        lines
    };
    let tables = blocks(&widths, width).into_iter().map(|block| {
        let head = set(&block, &table.head);
        let head = head.iter().map(|line| styled(HEADING, line) + "\n");
        let rows = table.rows.iter().flat_map(|row| set(&block, row));
        head.chain(rows.map(|line| line + "\n")).collect()
    });
    tables.collect::<Vec<String>>().join("\n")
}

/// Whether a column is not one of numbers.
fn is_of_words(table: &Table, column: usize) -> bool {
    let begins_number = |row: &Vec<String>| {
        let first = row[column].chars().find(|c| !matches!(c, '-' | '\u{2212}'));
        first.is_none_or(|c| c.is_ascii_digit())
    };
    column == 0 || !table.rows.iter().all(begins_number)
}

/// Columns of each table; empty ones are left out.
fn blocks(widths: &[usize], width: usize) -> Vec<Vec<usize>> {
    let mut blocks = vec![vec![0]];
    let mut used = widths[0];
    for column in (1..widths.len()).filter(|&column| widths[column] > 0) {
        let needed = GAP.len() + widths[column];
        let is_full = used + needed > width && blocks.last().is_some_and(|block| block.len() > 1);
        if is_full {
            blocks.push(vec![0]);
            used = widths[0];
        }
        used += needed;
        let block = blocks.last_mut();
        block.into_iter().for_each(|block| block.push(column));
    }
    blocks
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_fit_the_width() {
        let plain = |head: &[&str], row: &[&str], width| {
            let row = row.iter().map(|cell| (*cell).to_owned()).collect();
            let said = text(&Table::of("", head, [row]), width);
            anstream::adapter::strip_str(&said).to_string()
        };
        let (head, row) = (
            ["order", "ratio", "error", "speed"],
            ["1", "2.5", "0.1", "3"],
        );
        let whole = "order  ratio  error  speed\n1        2.5    0.1      3\n";
        assert_eq!(plain(&head, &row, 80), whole);
        let in_two = "order  ratio  error\n1        2.5    0.1\n\norder  speed\n1          3\n";
        assert_eq!(plain(&head, &row, 20), in_two);
        // A long first column is wrapped, and an empty one left out.
        let (head, row) = (
            ["", "first", ""],
            ["share passed from low to high k", "0.25", ""],
        );
        let wrapped = "              first\nshare passed\nfrom low to\nhigh k         0.25\n";
        assert_eq!(plain(&head, &row, 30), wrapped);
    }
}
