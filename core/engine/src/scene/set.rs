//! `--set PATH=VALUE`: replaces values of a scene file.

use super::source::{SceneError, Source};
use toml_edit::{Array, DocumentMut, Item, Value};

/// The text of a scene with `settings` (path, value) applied; other lines stay as they are.
pub(super) fn apply(source: &Source, settings: &[(String, String)]) -> Result<String, SceneError> {
    let parsed: Result<DocumentMut, toml_edit::TomlError> = source.text.parse();
    let mut document = parsed.map_err(|e| source.error(e.span().unwrap_or(0..0), e.message().trim().to_owned()))?;
    for (path, value) in settings {
        // A value that is not valid TOML is a string: `--set time.dt=2ms` needs no quotes.
        let value: Value = value.parse().unwrap_or_else(|_| Value::from(value.as_str()));
        put(document.as_item_mut(), path, value).map_err(|reason| source.whole(format!("--set {path}: {reason}")))?;
    }
    Ok(document.to_string())
}

/// Sets the value at a dotted path; the error is the reason why there is no such path.
fn put(root: &mut Item, path: &str, value: Value) -> Result<(), String> {
    let mut at = root;
    let mut done = String::new();
    let mut keys = path.split('.');
    while let Some(key) = keys.next() {
        if key.is_empty() {
            return Err("a part of the path is empty; allowed is, for example, body.0.material.params.young".into());
        }
        if let Item::Value(Value::Array(list)) = at {
            return put_into_list(list, key, &mut keys, &mut done, value);
        }
        at = step(at, key, &done)?;
        extend(&mut done, key);
    }
    *at = Item::Value(value);
    Ok(())
}

/// Replaces an entry of an array of values, or of an array within it: `device.0.frame.from.1`.
fn put_into_list<'a>(
    list: &mut Array,
    key: &str,
    keys: &mut impl Iterator<Item = &'a str>,
    done: &mut String,
    value: Value,
) -> Result<(), String> {
    let index: usize = key.parse().map_err(|_| format!("`{done}` is a list: `{key}` must be a number from 0"))?;
    let count = list.len();
    let Some(entry) = list.get_mut(index) else {
        return Err(format!("`{done}` has {count} entries, from 0: there is no {index}"));
    };
    extend(done, key);
    match (keys.next(), entry) {
        (None, entry) => *entry = value,
        (Some(key), Value::Array(inner)) => return put_into_list(inner, key, keys, done, value),
        (Some(key), _) => return Err(format!("`{done}` is a value and has no `{key}`")),
    }
    Ok(())
}

/// Appends a key to the path so far.
fn extend(done: &mut String, key: &str) {
    if !done.is_empty() {
        done.push('.');
    }
    done.push_str(key);
}

/// The item of a table or an array of tables at a key.
fn step<'a>(at: &'a mut Item, key: &str, done: &str) -> Result<&'a mut Item, String> {
    let index = || key.parse::<usize>().map_err(|_| format!("`{done}` is a list: `{key}` must be a number from 0"));
    let count = at.as_array_of_tables().map_or(0, |list| list.len());
    let beyond = |i: usize| format!("`{done}` has {count} entries, from 0: there is no {i}");
    match at {
        Item::ArrayOfTables(list) => {
            // A table of an array has no item of its own; go to it by the key after the index.
            let i = index()?;
            list.get_mut(i).map(|_| ()).ok_or_else(|| beyond(i))?;
            Ok(&mut at[i])
        }
        Item::Value(Value::InlineTable(_)) | Item::Table(_) | Item::None => Ok(&mut at[key]),
        Item::Value(_) => Err(format!("`{done}` is a value and has no `{key}`")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn set(text: &str, settings: &[(&str, &str)]) -> Result<String, String> {
        let source = Source::new("scene.toml", text);
        let settings: Vec<_> = settings.iter().map(|(p, v)| ((*p).to_owned(), (*v).to_owned())).collect();
        apply(&source, &settings).map_err(|e| e.to_string())
    }

    #[test]
    fn replaces_adds_and_leaves_the_rest_alone() {
        let text = "# head\nformat = 1\n[[body]]\nname = \"a\" # here\nmaterial = { plugin = \"m\" }\n[[body]]\nname = \"b\"\n";
        let out =
            set(text, &[("body.1.name", "c"), ("body.0.material.params.young", "2e5"), ("time.dt", "2 ms")]).unwrap();
        let read: toml::Table = out.parse().unwrap();
        assert_eq!(read["body"][1]["name"].as_str(), Some("c"));
        assert_eq!(read["body"][0]["material"]["params"]["young"].as_float(), Some(2e5));
        assert_eq!(read["time"]["dt"].as_str(), Some("2 ms"));
        let head = "# head\nformat = 1\ntime = { dt = \"2 ms\" }\n[[body]]\nname = \"a\" # here\n";
        assert!(out.starts_with(head), "{out}");
    }

    #[test]
    fn replaces_an_entry_of_a_list() {
        let text = "format = 1\n[[device]]\npath = [[0.0, 1.0], [2.0, 3.0]]\nfrom = [1.5, 0.5]\n";
        let out = set(text, &[("device.0.path.1.0", "7"), ("device.0.from.1", "0.25")]).unwrap();
        let read: toml::Table = out.parse().unwrap();
        assert_eq!(read["device"][0]["path"][1][0].as_integer(), Some(7));
        assert_eq!(read["device"][0]["from"].to_string(), "[1.5, 0.25]");
        for (path, part) in
            [("device.0.from.2", "there is no 2"), ("device.0.from.1.0", "has no `0`"), ("device.0.from.x", "a number")]
        {
            let error = set(text, &[(path, "1")]).unwrap_err();
            assert!(error.contains(part), "{error}");
        }
    }

    #[test]
    fn says_what_is_wrong_with_a_path() {
        let text = "format = 1\n[[body]]\nname = \"a\"\n";
        for (path, part) in [
            ("body.7.name", "there is no 7"),
            ("body.name", "must be a number"),
            ("format.x", "has no `x`"),
            ("body..name", "empty"),
        ] {
            let error = set(text, &[(path, "1")]).unwrap_err();
            assert!(error.contains(part) && error.contains(path), "{error}");
        }
    }
}
