//! Names and times of the strokes that the session can take back.

/// A stroke that can be taken back.
#[derive(Clone, Debug, PartialEq)]
pub struct Stroke {
    /// Which tool.
    pub name: &'static str,
    /// s, wall-clock time since the model was opened
    pub time: f64,
}

/// Follows the counts of the session's history and gives them names.
#[derive(Clone, Debug, Default)]
pub struct StrokeLog {
    strokes: Vec<Stroke>,
    done: usize,
    name: &'static str,
}

impl StrokeLog {
    /// The next stroke is called this.
    pub fn name_next(&mut self, name: &'static str) {
        self.name = name;
    }

    /// Takes over the counts of edits that can be taken back and that can be made again, at `time` (s); gives whether they differ from
    /// the last ones.
    pub fn update(&mut self, (done, undone): (usize, usize), time: f64) -> bool {
        let before = (self.done, self.strokes.len());
        if done > self.done && undone == 0 {
            // New strokes; those that were taken back are gone.
            self.strokes.truncate(self.done);
            self.strokes.resize(done, Stroke { name: self.name, time });
        } else if done + undone < self.strokes.len() {
            // A stroke that has changed nothing, or the oldest of a full history.
            self.strokes.truncate(done + undone);
        }
        self.done = done.min(self.strokes.len());
        before != (self.done, self.strokes.len())
    }

    /// Strokes that are there, then those taken back.
    pub fn strokes(&self) -> &[Stroke] {
        &self.strokes
    }

    /// How many are there.
    pub fn done(&self) -> usize {
        self.done
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(log: &StrokeLog) -> Vec<&'static str> {
        log.strokes().iter().map(|stroke| stroke.name).collect()
    }

    #[test]
    fn names_follow_strokes_undo_and_redo() {
        let mut log = StrokeLog::default();
        for (name, count) in [("press", 1), ("pull", 2), ("knife", 3)] {
            log.name_next(name);
            assert!(log.update((count, 0), 1.0));
        }
        assert!(!log.update((3, 0), 2.0));
        assert!(log.update((2, 1), 3.0) && log.update((1, 2), 3.0));
        assert_eq!((names(&log), log.done()), (vec!["press", "pull", "knife"], 1));
        assert!(log.update((2, 1), 4.0));
        assert_eq!(log.done(), 2);
        log.name_next("grab");
        log.update((3, 0), 5.0);
        assert_eq!((names(&log), log.done()), (vec!["press", "pull", "grab"], 3));
        // A stroke under way counts, and no longer if it has changed nothing.
        log.name_next("touch");
        log.update((4, 0), 6.0);
        log.update((3, 0), 7.0);
        assert_eq!((names(&log), log.done()), (vec!["press", "pull", "grab"], 3));
    }
}
