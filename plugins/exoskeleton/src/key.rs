//! Message authentication with a shared key: SipHash-2-4 with a 128 bit tag (Aumasson and Bernstein 2012). SipHash is made for short
//! messages; a datagram takes less than a microsecond.

use siphasher::sip128::{Hasher128, SipHasher24};
use std::hash::Hasher;

/// Bytes of an authentication tag.
pub const TAG_BYTES: usize = 16;

/// A secret key of 128 bits that the host and the device share.
#[derive(Clone)]
pub struct Key(SipHasher24);

impl Key {
    /// The key with these bytes.
    pub fn new(bytes: &[u8; 16]) -> Self {
        Self(SipHasher24::new_with_key(bytes))
    }

    /// Reads a key from a file of 32 hexadecimal digits; white space around them is ignored.
    ///
    /// # Errors
    /// If the file cannot be read or holds something else. The message names the file and never shows its contents.
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

    /// The authentication tag of a message.
    pub fn tag(&self, message: &[u8]) -> [u8; TAG_BYTES] {
        let mut hasher = self.0;
        hasher.write(message);
        hasher.finish128().as_bytes()
    }

    /// Whether `tag` is the tag of `message`. Takes the same time for every wrong tag, so that the time says nothing about the right
    /// one.
    pub fn verify(&self, message: &[u8], tag: &[u8]) -> bool {
        let expected = self.tag(message);
        tag.len() == TAG_BYTES && expected.iter().zip(tag).fold(0, |difference, (a, b)| difference | (a ^ b)) == 0
    }
}
