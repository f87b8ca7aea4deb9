//! Names and times of the strokes that the session can take back.

/// A stroke that can be taken back.
#[derive(Clone, Debug, PartialEq)]
pub struct Stroke {
    /// Name of the tool that made the stroke.
    pub name: &'static str,
    /// s, wall-clock time since the model was opened
    pub time: f64,
    /// Number of the stroke of the pointer; a mirrored one is two strokes of the session.
    pub number: u64,
}

/// Follows the counts of the session's history and gives them names.
#[derive(Clone, Debug, Default)]
pub struct StrokeLog {
    strokes: Vec<Stroke>,
    done: usize,
    name: &'static str,
    number: u64,
}

impl StrokeLog {
    /// A stroke begins that is called this.
    pub fn begin(&mut self, name: &'static str) {
        (self.name, self.number) = (name, self.number + 1);
    }

    /// How many strokes of the session are there without the last stroke of the pointer.
    pub fn count_before(&self) -> usize {
        let last = self.done.checked_sub(1).map(|place| self.strokes[place].number);
        self.strokes[..self.done].iter().take_while(|stroke| Some(stroke.number) != last).count()
    }

    /// How many are there once the stroke of the pointer that was taken back last is made again.
    pub fn count_after(&self) -> usize {
        let next = self.strokes.get(self.done).map(|stroke| stroke.number);
        let again = self.strokes[self.done..].iter().take_while(|stroke| Some(stroke.number) == next).count();
        self.done + again
    }

    /// Takes over the counts of edits that can be taken back and that can be made again, at `time` (s); gives whether they differ from
    /// the last ones.
    pub fn update(&mut self, (done, undone): (usize, usize), time: f64) -> bool {
        let before = (self.done, self.strokes.len());
        if done > self.done && undone == 0 {
            // New strokes; those that were taken back are gone.
            self.strokes.truncate(self.done);
            self.strokes.resize(done, Stroke { name: self.name, time, number: self.number });
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
            log.begin(name);
            assert!(log.update((count, 0), 1.0));
        }
        assert!(!log.update((3, 0), 2.0));
        assert!(log.update((2, 1), 3.0) && log.update((1, 2), 3.0));
        assert_eq!((names(&log), log.done()), (vec!["press", "pull", "knife"], 1));
        assert!(log.update((2, 1), 4.0));
        assert_eq!(log.done(), 2);
        log.begin("grab");
        log.update((3, 0), 5.0);
        assert_eq!((names(&log), log.done()), (vec!["press", "pull", "grab"], 3));
        // Two strokes of the session that belong to one of the pointer are taken back and made again together.
        log.begin("mirrored");
        log.update((5, 0), 5.5);
        assert_eq!((log.count_before(), log.count_after()), (3, 5));
        log.update((3, 2), 5.6);
        assert_eq!((log.count_before(), log.count_after()), (2, 5));
        // A stroke under way counts, and no longer if it has changed nothing.
        log.begin("touch");
        log.update((4, 0), 6.0);
        log.update((3, 0), 7.0);
        assert_eq!((names(&log), log.done()), (vec!["press", "pull", "grab"], 3));
    }
}
