//! Every link of the documentation leads somewhere: to a file, a heading or a page of the book; and files the text names exist.

use pliant_tests::root;
use std::path::{Path, PathBuf};

/// The pages people read, relative to the root.
fn pages() -> Vec<PathBuf> {
    let in_folder = |folder: &str| {
        let entries = std::fs::read_dir(root().join(folder)).expect("a folder").flatten();
        let markdown = entries.map(|entry| entry.path()).filter(|path| path.extension().is_some_and(|x| x == "md"));
        markdown.map(|path| path.strip_prefix(root()).expect("inside").to_path_buf()).collect::<Vec<_>>()
    };
    let mut pages = [in_folder("."), in_folder("docs")].concat();
    pages.sort();
    pages
}

fn text(page: &Path) -> String {
    let text = std::fs::read_to_string(root().join(page)).unwrap_or_else(|e| panic!("{}: {e}", page.display()));
    // What stands in a fenced block is code, and no link.
    text.split("```").step_by(2).collect()
}

/// Targets of inline links, `[text](target)`.
fn links(text: &str) -> Vec<&str> {
    let ends = text.match_indices("](").map(|(at, mark)| &text[at + mark.len()..]);
    ends.filter_map(|rest| rest.split_once(')')).map(|(target, _)| target).collect()
}

/// The anchors of a page's headings, as GitHub and mdBook form them.
fn anchors(text: &str) -> Vec<String> {
    let headings = text.lines().filter(|line| line.starts_with('#')).map(|line| line.trim_start_matches('#').trim());
    headings
        .map(|heading| {
            let kept = heading.chars().filter(|c| c.is_alphanumeric() || " -_".contains(*c));
            kept.flat_map(char::to_lowercase).map(|c| if c == ' ' { '-' } else { c }).collect()
        })
        .collect()
}

/// Whether there is a file of this name; the last part may have one `*`.
fn exists(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let Some((start, end)) = name.split_once('*') else { return path.exists() };
    let entries = path.parent().and_then(|folder| folder.read_dir().ok()).into_iter().flatten().flatten();
    entries
        .map(|entry| entry.file_name().to_string_lossy().into_owned())
        .any(|n| n.starts_with(start) && n.ends_with(end))
}

#[test]
fn links_lead_to_files_and_headings() {
    let mut wrong = Vec::new();
    for page in pages() {
        let own = text(&page);
        for link in links(&own).into_iter().filter(|link| !link.contains("://")) {
            let (file, anchor) = link.split_once('#').map_or((link, None), |(file, anchor)| (file, Some(anchor)));
            let target = if file.is_empty() { page.clone() } else { page.parent().expect("a file").join(file) };
            let found = root().join(&target).exists();
            let has = |anchor: &str| anchors(&text(&target)).iter().any(|a| a == anchor);
            if !found || anchor.is_some_and(|anchor| !has(anchor)) {
                wrong.push(format!("{}: {link}", page.display()));
            }
        }
    }
    assert!(wrong.is_empty(), "\n{}", wrong.join("\n"));
}

/// A path in backticks that begins with a folder of the repository is there. The changelog may name what is gone.
#[test]
fn files_the_text_names_exist() {
    let entries = std::fs::read_dir(root()).expect("the repository").flatten().filter(|entry| entry.path().is_dir());
    let mut folders: Vec<String> = entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    folders.retain(|folder| !["target", "out", ".git"].contains(&folder.as_str()));
    let mut wrong = Vec::new();
    for page in pages().into_iter().filter(|page| page != Path::new("CHANGELOG.md")) {
        let text = text(&page);
        for name in text.split('`').skip(1).step_by(2).filter(|name| !name.contains(char::is_whitespace)) {
            let is_path = name.split_once('/').is_some_and(|(first, _)| folders.iter().any(|folder| folder == first));
            if is_path && !exists(&root().join(name)) {
                wrong.push(format!("{}: {name}", page.display()));
            }
        }
    }
    assert!(wrong.is_empty(), "\n{}", wrong.join("\n"));
}

/// The book has every page of `docs/`, once.
#[test]
fn the_book_has_every_page() {
    let summary = text(Path::new("docs/SUMMARY.md"));
    let mut listed: Vec<&str> = links(&summary);
    listed.sort_unstable();
    let inside = pages().into_iter().filter_map(|page| Some(page.strip_prefix("docs").ok()?.display().to_string()));
    let inside: Vec<String> = inside.filter(|page| page != "SUMMARY.md").collect();
    assert_eq!(listed, inside);
}
