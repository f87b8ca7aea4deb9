//! The text of a scene with the places of its lines.

use std::fmt;
use std::ops::Deref;
use std::sync::OnceLock;

/// A text whose lines are found once, so that the place of each of many entries does not take a pass over the text.
#[derive(Clone, Default)]
pub struct SceneText {
    text: String,
    /// Where each line begins, bytes; found when a place is first asked for.
    lines: OnceLock<Vec<usize>>,
}

impl SceneText {
    /// The line of a byte of the text, from 1, and where that line begins, bytes.
    pub(super) fn line_of(&self, at: usize) -> (usize, usize) {
        let lines = self
            .lines
            .get_or_init(|| std::iter::once(0).chain(self.text.match_indices('\n').map(|(end, _)| end + 1)).collect());
        let number = lines.partition_point(|begins| *begins <= at);
        (number, lines[number - 1])
    }
}

impl<T: Into<String>> From<T> for SceneText {
    fn from(text: T) -> Self {
        Self { text: text.into(), lines: OnceLock::new() }
    }
}

impl Deref for SceneText {
    type Target = str;

    fn deref(&self) -> &str {
        &self.text
    }
}

impl fmt::Debug for SceneText {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.text.fmt(f)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_line_of_each_byte_is_that_of_counting() {
        for text in ["", "a", "\n", "a\nbc\n\nd", "\n\n", "ends\n"] {
            let of = SceneText::from(text);
            for at in 0..=text.len() {
                let begins = text[..at].rfind('\n').map_or(0, |end| end + 1);
                assert_eq!(of.line_of(at), (text[..at].matches('\n').count() + 1, begins), "{text:?} {at}");
            }
        }
    }
}
