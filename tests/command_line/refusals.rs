//! What cannot be done is refused with its code and a word that helps, and leaves nothing: a command a row of `refusals.txt`.

use test_support::place::text;

use crate::sessions::Session;

#[test]
fn regress_what_cannot_be_done_is_refused() {
    let mut session = Session::of(test_support::pulse::place());
    let rows = include_str!("refusals.txt").lines();
    let mut wrong = Vec::new();
    for row in rows.filter(|row| !row.is_empty() && !row.starts_with('#')) {
        if let Some(line) = row.strip_prefix("> ") {
            assert!(session.holds(line), "{line}");
            continue;
        }
        let place = &session.place;
        let parts: Vec<&str> = row.split(" | ").collect();
        let typed: Vec<String> = parts[1].split(' ').map(|w| w.replace('~', " ")).collect();
        let typed: Vec<&str> = typed.iter().map(String::as_str).collect();
        let before = place.names();
        let output = place.run(&typed);
        let said = text(&output.stderr);
        let holds = |word: &str| match word.strip_prefix("not ") {
            Some(word) => !said.contains(word),
            None => said.contains(word),
        };
        let is_right = output.status.code() == parts[0].parse().ok()
            && output.stdout.is_empty()
            && said.starts_with("error: ")
            && place.names() == before
            && parts[2].split(" ; ").all(holds);
        if !is_right {
            wrong.push(format!("{row}\n{:?} {said}", output.status.code()));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
