//! A key both sides know, and the tag it puts under a datagram: SipHash-2-4 with 128 bits (Aumasson and Bernstein 2012), which
//! was made for short messages and takes less than a microsecond here.

use siphasher::sip128::{Hasher128, SipHasher24};
use std::hash::Hasher;

/// Bytes of a tag.
pub const TAG: usize = 16;

/// A shared secret.
#[derive(Clone)]
pub struct Key(SipHasher24);

impl Key {
    /// From 16 bytes.
    pub fn new(bytes: &[u8; 16]) -> Self {
        Self(SipHasher24::new_with_key(bytes))
    }

    /// From a file that holds 32 hexadecimal digits.
    ///
    /// # Errors
    /// A sentence that names the file, and never what is in it.
    pub fn from_file(file: &str) -> Result<Self, String> {
        let text = std::fs::read_to_string(file).map_err(|e| format!("{file}: {e}"))?;
        let digits = text.trim();
        let wrong = || format!("{file}: not a key; allowed is 32 hexadecimal digits");
        if digits.len() != 32 || !digits.bytes().all(|b| b.is_ascii_hexdigit()) {
            return Err(wrong());
        }
        let mut bytes = [0; 16];
        for (i, byte) in bytes.iter_mut().enumerate() {
            *byte = u8::from_str_radix(&digits[2 * i..2 * i + 2], 16).map_err(|_| wrong())?;
        }
        Ok(Self::new(&bytes))
    }

    /// The tag of a message.
    pub fn tag(&self, message: &[u8]) -> [u8; TAG] {
        let mut hasher = self.0;
        hasher.write(message);
        hasher.finish128().as_bytes()
    }

    /// Whether a tag is the message's; takes as long for a wrong one as for the right one.
    pub fn is_tag(&self, message: &[u8], tag: &[u8]) -> bool {
        let own = self.tag(message);
        tag.len() == TAG && own.iter().zip(tag).fold(0, |differ, (a, b)| differ | (a ^ b)) == 0
    }
}
