//! Lists of files as programs write them when files are dragged (RFC 2483): a URI on each line.

use std::ffi::OsString;
use std::os::unix::ffi::OsStringExt;
use std::path::PathBuf;

/// The entries of a list: a path for each URI of a file of this machine, and the URI itself where it is none.
///
/// Lines may end in a line feed alone, and the list in a NUL, as some programs write it. `host`: the name of this machine, which a URI may give.
pub fn files(list: &[u8], host: &str) -> Vec<Result<PathBuf, String>> {
    let lines = list.split(|byte| matches!(byte, b'\r' | b'\n' | 0)).map(<[u8]>::trim_ascii);
    let uris = lines.filter(|line| !line.is_empty() && !line.starts_with(b"#"));
    uris.map(|uri| file(uri, host).ok_or_else(|| String::from_utf8_lossy(uri).into_owned())).collect()
}

/// The path of a URI of a file of this machine: `file:///path`, `file://host/path` or `file:/path`.
fn file(uri: &[u8], host: &str) -> Option<PathBuf> {
    let (scheme, rest) = uri.split_at_checked(5)?;
    if !scheme.eq_ignore_ascii_case(b"file:") {
        return None;
    }
    let path = match rest.strip_prefix(b"//") {
        None => rest,
        Some(rest) => {
            let (authority, path) = rest.split_at(rest.iter().position(|byte| *byte == b'/')?);
            let is_here =
                [&b""[..], b"localhost", host.as_bytes()].iter().any(|name| name.eq_ignore_ascii_case(authority));
            is_here.then_some(path)?
        }
    };
    path.starts_with(b"/").then(|| PathBuf::from(OsString::from_vec(percent_decoded(path))))
}

/// Bytes with every `%XX` replaced by the byte that it stands for. A percent sign before anything else stands for itself.
fn percent_decoded(text: &[u8]) -> Vec<u8> {
    let digit = |place: usize| text.get(place).and_then(|byte| char::from(*byte).to_digit(16));
    let (mut decoded, mut place) = (Vec::with_capacity(text.len()), 0);
    while let Some(&byte) = text.get(place) {
        match (byte, digit(place + 1), digit(place + 2)) {
            (b'%', Some(high), Some(low)) => {
                decoded.push((16 * high + low) as u8);
                place += 3;
            }
            _ => {
                decoded.push(byte);
                place += 1;
            }
        }
    }
    decoded
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::ffi::OsStrExt;

    #[test]
    fn each_line_is_a_path_or_a_uri_that_is_no_file_here() {
        let list = b"# a comment\r\nfile:///a/zwei%20B%C3%A4lle%2520.obj\r\nfile://localhost/b.obj\nFILE://Here/c.obj\r\nfile:/d.obj\r\n\
            file://there/e.obj\r\nsftp://here/f.obj\r\nfile:g.obj\r\nfile://h\r\n\0";
        let found = files(list, "here");
        let expected = [
            Ok("/a/zwei Bälle%20.obj"),
            Ok("/b.obj"),
            Ok("/c.obj"),
            Ok("/d.obj"),
            Err("file://there/e.obj"),
            Err("sftp://here/f.obj"),
            Err("file:g.obj"),
            Err("file://h"),
        ];
        assert_eq!(found, expected.map(|entry| entry.map(PathBuf::from).map_err(str::to_owned)));
    }

    #[test]
    fn names_are_bytes_and_stray_percent_signs_stay() {
        let found = files(b"file:///B%E4lle%2.obj\r\nfile:///100%", "");
        let paths: Vec<&[u8]> = found.iter().map(|entry| entry.as_ref().unwrap().as_os_str().as_bytes()).collect();
        assert_eq!(paths, [&b"/B\xe4lle%2.obj"[..], b"/100%"]);
    }
}
