//! Text that is safe on a terminal: what files, scenes and plugins hold may contain control sequences.

use std::borrow::Cow;
use std::fmt::Write;

/// The text with every control character but line breaks and tabs, and every character that changes the direction of writing, as `\uXXXX`
/// with its code in hexadecimal. A terminal would obey such characters: ESC and U+009B begin sequences that recolour, move, retitle or
/// answer. The form is that of JSON, in whose strings it stands for the same character, so a JSON document stays what it was.
pub fn escape_controls(text: &str) -> Cow<'_, str> {
    if !text.contains(is_escaped) {
        return Cow::Borrowed(text);
    }
    let mut escaped = String::with_capacity(text.len() + 16);
    for character in text.chars() {
        if is_escaped(character) {
            // Into a `String` it cannot fail.
            let _ = write!(escaped, "\\u{:04x}", u32::from(character));
        } else {
            escaped.push(character);
        }
    }
    Cow::Owned(escaped)
}

/// Whether a character acts on the terminal instead of being shown. Those of direction are Unicode's explicit formatting characters
/// (UAX #9, section 2).
fn is_escaped(character: char) -> bool {
    match character {
        '\n' | '\t' => false,
        '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}' => true,
        other => other.is_control(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_character_is_itself_or_its_code() {
        for character in '\0'..=char::MAX {
            let text = character.to_string();
            let escaped = escape_controls(&text);
            let acts = character.is_control() && !"\n\t".contains(character);
            if acts {
                assert_eq!(escaped, format!("\\u{:04x}", u32::from(character)));
            } else if escaped != text {
                let spoken: String = serde_json::from_str(&format!("\"{escaped}\"")).unwrap();
                assert_eq!(spoken, text);
            }
        }
    }

    #[test]
    fn a_json_document_stays_what_it_was() {
        let all: String = ('\0'..='\u{2fff}').collect();
        let document = serde_json::json!({ all.as_str(): [all.as_str()] });
        let escaped = serde_json::to_string_pretty(&document).unwrap();
        let escaped = escape_controls(&escaped);
        assert!(!escaped.chars().any(is_escaped));
        assert_eq!(serde_json::from_str::<serde_json::Value>(&escaped).unwrap(), document);
    }

    #[test]
    fn other_text_is_not_copied() {
        assert!(matches!(escape_controls("körper: \t5 mm\n  ^ here, 人, ≤"), Cow::Borrowed(_)));
    }
}
