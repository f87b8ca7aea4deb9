//! Every text that people read in the window stands in one file, to be translated there.

use std::path::{Path, PathBuf};

/// Files whose literals are for the terminal, the graphics driver, or are the texts themselves.
const LEFT_OUT: [&str; 4] = ["strings.rs", "arguments.rs", "main.rs", "shaders.rs"];

/// What stands right before a literal that no user of the window reads: events of the log and keys of their fields, names of threads, identifiers of
/// widgets, reasons of lints, panics of calls that do not fail, headers of exported files.
const NOT_SHOWN: [&str; 8] =
    [".event(", "&[(", "reason =", ".expect(", ".with((", ".name(", "generator = Some(format!(", ".copy_from_slice(b"];

/// Calls whose first argument is shown, whatever it is.
const SHOWS: [&str; 12] = [
    ".label(",
    ".heading(",
    ".button(",
    ".text(",
    ".suffix(",
    "row(",
    "hover_text(",
    "selectable_label(",
    ".small(",
    "add_filter(",
    ".tell(",
    ".fail(",
];

/// A string literal: its line, what stands before it, and its text.
struct Literal {
    line: usize,
    before: String,
    text: String,
}

/// The literals of a source file, without comments and without its tests.
fn literals(source: &str) -> Vec<Literal> {
    let source = source.split("#[cfg(test)]\nmod tests").next().unwrap_or_default();
    let (mut found, mut line, mut code) = (Vec::new(), 1, String::new());
    let mut chars = source.chars().peekable();
    while let Some(c) = chars.next() {
        match c {
            '/' if chars.peek() == Some(&'/') => {
                chars.by_ref().find(|c| *c == '\n');
                line += 1;
            }
            '\'' => {
                // A character, such as '"', or a lifetime.
                let ahead: Vec<char> = chars.clone().take(2).collect();
                if ahead.first() == Some(&'\\') {
                    chars.by_ref().nth(1);
                    chars.by_ref().find(|c| *c == '\'');
                } else if ahead.get(1) == Some(&'\'') {
                    chars.by_ref().nth(1);
                }
            }
            '"' => {
                let (began, mut text) = (line, String::new());
                while let Some(c) = chars.next() {
                    match c {
                        '"' => break,
                        '\\' => text.extend(chars.next().filter(|c| !c.is_alphanumeric())),
                        c => text.push(c),
                    }
                    line += usize::from(c == '\n');
                }
                let before = code.split_whitespace().collect::<Vec<_>>().join(" ");
                found.push(Literal { line: began, before, text });
                code.clear();
            }
            c => {
                line += usize::from(c == '\n');
                code.push(c);
            }
        }
    }
    found
}

/// The text without the places of a format string.
fn words(text: &str) -> Vec<String> {
    let (mut plain, mut depth) = (String::new(), 0);
    for c in text.chars() {
        match c {
            '{' => depth += 1,
            '}' => depth -= 1,
            c if depth == 0 => plain.push(c),
            _ => {}
        }
    }
    let is_word = |word: &&str| word.len() > 1 && word.chars().all(|c| c.is_alphabetic() || ",.;:!?'".contains(c));
    plain.split_whitespace().filter(is_word).map(str::to_owned).collect()
}

/// Whether people would read it: two words or more, a word beside a value, or anything that is handed to what shows it.
fn is_shown(literal: &Literal) -> bool {
    if NOT_SHOWN.iter().any(|before| literal.before.ends_with(before)) {
        return false;
    }
    let count = words(&literal.text).len();
    let shows = SHOWS.iter().any(|call| {
        let before = literal.before.trim_end_matches("format!(").trim_end();
        before.ends_with(call)
    });
    let beside_a_value = literal.text.contains('{') && literal.text.contains(' ');
    count > 1 || count == 1 && (beside_a_value || shows)
}

fn sources(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path());
    let mut all: Vec<PathBuf> = Vec::new();
    for path in entries {
        match path.is_dir() {
            true => all.extend(sources(&path)),
            false => all.push(path),
        }
    }
    all.sort();
    all
}

#[test]
fn every_text_of_the_window_stands_in_one_file() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut elsewhere = Vec::new();
    let mut read = 0;
    for path in sources(&root) {
        let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
        if LEFT_OUT.contains(&name) {
            continue;
        }
        read += 1;
        let source = std::fs::read_to_string(&path).expect("a source file");
        for literal in literals(&source).iter().filter(|literal| is_shown(literal)) {
            let place = path.strip_prefix(&root).unwrap_or(&path).display();
            elsewhere.push(format!("{place}:{}: {:?}", literal.line, literal.text));
        }
    }
    assert!(read > 30, "{read} files");
    assert!(elsewhere.is_empty(), "texts outside of strings.rs:\n{}", elsewhere.join("\n"));
}

#[test]
fn texts_are_told_from_names() {
    let shown = |code: &str| literals(code).iter().filter(|literal| is_shown(literal)).count();
    for code in [
        "self.tell(format!(\"saved {}\", path.display()));",
        "row(\"step\", value);",
        "ui.label(\"force\");",
        "return Err(\"there is no home folder\".into());",
        "let c = '\"'; ui.button(\"Open it\");",
        "f('\\'', \"two words\")",
    ] {
        assert_eq!(shown(code), 1, "{code}");
    }
    for code in [
        "self.log.event(\"stroke begins\", &[(\"tool\", name)]);",
        "egui::Panel::left(\"tools\")",
        "// \"two words\"\nlet x = strings::SAVE;",
        "format!(\"{}-{}\", a, b)",
        "#[allow(unsafe_code, reason = \"every call of OpenGL\")]",
        "path.with_extension(\"obj\")",
    ] {
        assert_eq!(shown(code), 0, "{code}");
    }
}
