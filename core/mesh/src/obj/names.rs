//! Parts of a document by name: faces under `g` and `o` lines.

use super::ObjDocument;

impl ObjDocument {
    /// Whether each face (f) is under a `g` or `o` line with this name; `None` if no line has it. A line names all its words, and the whole of
    /// them.
    pub fn faces_named(&self, name: &str) -> Option<Vec<bool>> {
        let has_name = |line: &String| line == name || line.split_whitespace().any(|word| word == name);
        let groups: Vec<bool> = self.groups().iter().map(has_name).collect();
        let objects: Vec<bool> = self.objects().iter().map(has_name).collect();
        if !groups.iter().chain(&objects).any(|is_named| *is_named) {
            return None;
        }
        let is_in = |named: &[bool], index: Option<u32>| index.is_some_and(|index| named[index as usize]);
        let of_face =
            self.faces().map(|face| is_in(&groups, face.attributes.group) || is_in(&objects, face.attributes.object));
        Some(of_face.collect())
    }

    /// All names of `g` and `o` lines, in quotes and with commas between, for messages.
    pub fn list_names(&self) -> String {
        let all: Vec<String> = self.groups().iter().chain(self.objects()).map(|name| format!("`{name}`")).collect();
        if all.is_empty() { "none: the model has no `g` and no `o` lines".into() } else { all.join(", ") }
    }
}

#[cfg(test)]
mod tests {
    use crate::testing::document;

    #[test]
    fn names_of_groups_and_objects_hold_their_faces() {
        let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\no hat\nf 1 2 3\ng rim left\nf 1 2 4\no hand\ng\nf 1 3 4\ng left\nf 2 3 4\ng nothing\n";
        let document = document(text);
        let named = |name: &str| document.faces_named(name);
        assert_eq!(named("hat"), Some(vec![true, true, false, false]));
        assert_eq!(named("left"), Some(vec![false, true, false, true]));
        assert_eq!(named("rim left"), Some(vec![false, true, false, false]));
        assert_eq!(named("nothing"), Some(vec![false; 4]));
        assert_eq!(named("le"), None);
        assert_eq!(document.list_names(), "`rim left`, `left`, `nothing`, `hat`, `hand`");
    }
}
