//! Texts in XML and HTML.

/// A text with the characters that have a meaning in XML replaced by their entities.
pub(crate) fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
