//! Message authentication with a shared key: SipHash-2-4 with a 128 bit tag (Aumasson and Bernstein 2012). SipHash is made for short
//! messages; a datagram takes less than a microsecond.

use core::net::IpAddr;
use siphasher::sip128::{Hasher128, SipHasher24};
use std::fs::File;
use std::hash::Hasher;
use std::io::Read;

/// Bytes of an authentication tag.
pub const TAG_BYTES: usize = 16;

/// Most bytes of a key file.
const MAX_FILE_BYTES: u64 = 1024;

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
    /// If the file cannot be read or holds something else, or if others than its owner may read or write it. The message names the file and never shows its
    /// contents.
    pub fn from_file(file: &str) -> Result<Self, String> {
        let named = |e: std::io::Error| format!("{file}: {e}");
        let opened = File::open(file).map_err(named)?;
        check_rights(&opened).map_err(|why| format!("{file}: {why}"))?;
        let mut text = String::new();
        opened.take(MAX_FILE_BYTES).read_to_string(&mut text).map_err(named)?;
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

/// Refuses a key file that others than its owner may read or write, as SSH does: who reads it moves the hand. Without Unix rights any file is taken.
fn check_rights(file: &File) -> Result<(), String> {
    #[cfg(unix)]
    {
        use std::os::unix::fs::MetadataExt;
        let metadata = file.metadata().map_err(|e| e.to_string())?;
        if !metadata.is_file() {
            return Err("no regular file; allowed is a file with 32 hexadecimal digits".into());
        }
        let rights = metadata.mode() & 0o777;
        if rights & 0o077 != 0 {
            return Err(format!("others may use this key (rights {rights:o}); allowed is its owner alone: chmod 600"));
        }
    }
    let _ = file;
    Ok(())
}

/// Refuses an address of a network without a key: anyone there could move the hand.
///
/// # Errors
/// If the address is not a loopback address and there is no key.
pub fn require_key(address: IpAddr, key: Option<&Key>) -> Result<(), String> {
    if key.is_some() || address.to_canonical().is_loopback() {
        return Ok(());
    }
    Err(format!("{address} is on a network; allowed is a `key` on both sides, or a loopback address such as 127.0.0.1"))
}
