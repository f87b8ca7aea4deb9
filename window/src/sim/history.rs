//! Names and times of what can be taken back: the strokes of the session, and changes of the stiffness, which the session does not remember.

use pliant_engine::session::HistoryCounts;

/// Something that can be taken back.
#[derive(Clone, Debug, PartialEq)]
pub struct Stroke {
    /// Name of the tool that made the stroke, or of the change.
    pub name: &'static str,
    /// s, wall-clock time since the model was opened
    pub time: f64,
    /// Number of the stroke of the pointer, which may be several of the session.
    pub number: u64,
    /// Of a change of the stiffness: the factor before and after it.
    pub stiffness: Option<[f64; 2]>,
}

/// What the session has to do to take something back or to make it again.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum HistoryStep {
    /// Undo the last stroke of the session.
    Undo,
    /// Redo the stroke of the session that was undone last.
    Redo,
    /// Give the bodies this factor of the stiffness they were opened with.
    Stiffness(f64),
}

/// Follows the counts of the session's history, and gives names to what is in it.
#[derive(Clone, Debug, Default)]
pub struct StrokeLog {
    strokes: Vec<Stroke>,
    done: usize,
    name: &'static str,
    number: u64,
    /// Number of the last stroke of the pointer.
    stroke: u64,
    /// Number of edits that the session can no longer take back, and of the last stroke among them.
    forgotten: u64,
    oldest: u64,
}

impl StrokeLog {
    /// A stroke begins that is called this.
    pub fn begin(&mut self, name: &'static str) {
        (self.name, self.number) = (name, self.number + 1);
        self.stroke = self.number;
    }

    /// The stiffness changes from a factor to another at `time` (s). Changes right after each other, as of a slider, are one. What was taken back is gone.
    pub fn change_stiffness(&mut self, name: &'static str, [before, after]: [f64; 2], time: f64) {
        if before == after {
            return;
        }
        self.strokes.truncate(self.done);
        if let Some(Stroke { stiffness: Some([first, last]), time: when, .. }) = self.strokes.last_mut() {
            (*last, *when) = (after, time);
            if *first == after {
                // Back where it was: there is nothing to take back.
                self.strokes.pop();
                self.done -= 1;
            }
            return;
        }
        let number = self.number + 1;
        self.strokes.push(Stroke { name, time, number, stiffness: Some([before, after]) });
        (self.number, self.done) = (number, self.strokes.len());
    }

    /// How many entries are there without the last stroke of the pointer.
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

    /// The next step towards `count` entries, which is taken as done; `None` once they are there.
    pub fn step_to(&mut self, count: usize) -> Option<HistoryStep> {
        if self.done > count {
            self.done -= 1;
            Some(match self.strokes[self.done].stiffness {
                Some([before, _]) => HistoryStep::Stiffness(before),
                None => HistoryStep::Undo,
            })
        } else if self.done < count.min(self.strokes.len()) {
            self.done += 1;
            Some(match self.strokes[self.done - 1].stiffness {
                Some([_, after]) => HistoryStep::Stiffness(after),
                None => HistoryStep::Redo,
            })
        } else {
            None
        }
    }

    /// Takes over the counts of edits of the session at `time` (s), and the number of those that it can no longer take back. Returns whether anything
    /// differs from the last ones.
    pub fn update(&mut self, edits: HistoryCounts, forgotten: u64, time: f64) -> bool {
        let HistoryCounts { done, undone } = edits;
        let before = (self.forgotten, self.done, self.strokes.len());
        self.forget(forgotten);
        let present = self.edits();
        if done > present && undone == 0 {
            // New strokes; those that were taken back are gone.
            self.strokes.truncate(self.done);
            let stroke = Stroke { name: self.name, time, number: self.number, stiffness: None };
            self.strokes.extend(std::iter::repeat_n(stroke, done - present));
            self.done = self.strokes.len();
        } else if done + undone < self.strokes.iter().filter(|stroke| stroke.stiffness.is_none()).count() {
            // A stroke that has changed nothing.
            let mut left = done + undone;
            self.strokes.retain(|stroke| {
                let is_kept = stroke.stiffness.is_some() || left > 0;
                left -= usize::from(stroke.stiffness.is_none() && left > 0);
                is_kept
            });
            self.done = self.place_of(done);
        } else if done != present {
            self.done = self.place_of(done);
        }
        before != (self.forgotten, self.done, self.strokes.len())
    }

    /// Removes the oldest edits until `forgotten` have gone since the beginning.
    fn forget(&mut self, forgotten: u64) {
        while self.forgotten < forgotten {
            self.forgotten += 1;
            if let Some(place) = self.strokes.iter().position(|stroke| stroke.stiffness.is_none()) {
                self.oldest = self.strokes.remove(place).number;
                self.done -= usize::from(place < self.done);
            }
        }
    }

    /// The place after so many edits of the session, and after the changes of the stiffness behind them that were there.
    fn place_of(&self, edits: usize) -> usize {
        let (mut place, mut left) = (0, edits);
        for (index, stroke) in self.strokes.iter().enumerate() {
            match stroke.stiffness {
                None if left == 0 => break,
                None => (place, left) = (index + 1, left - 1),
                Some(_) if index < self.done => place = index + 1,
                Some(_) => {}
            }
        }
        place
    }

    /// Entries that are there, then those taken back.
    pub fn strokes(&self) -> &[Stroke] {
        &self.strokes
    }

    /// How many of those that are there have ended, where `is_under_way` tells whether the last stroke of the pointer has not.
    pub fn ended(&self, is_under_way: bool) -> usize {
        let has_ended = |stroke: &&Stroke| !is_under_way || stroke.number != self.stroke;
        self.strokes[..self.done].iter().filter(has_ended).count()
    }

    /// How many are there.
    pub fn done(&self) -> usize {
        self.done
    }

    /// How many of those that are there are edits of the session.
    pub fn edits(&self) -> usize {
        self.strokes[..self.done].iter().filter(|stroke| stroke.stiffness.is_none()).count()
    }

    /// The present shape: the number of the last stroke that has edited it, 0 as it was opened. An undo and another stroke make another shape, however many
    /// strokes it has.
    pub fn shape(&self) -> u64 {
        let last = self.strokes[..self.done].iter().rfind(|stroke| stroke.stiffness.is_none());
        last.map_or(self.oldest, |stroke| stroke.number)
    }
}
#[cfg(test)]
mod tests {
    use super::*;

    fn edits(done: usize, undone: usize) -> HistoryCounts {
        HistoryCounts { done, undone }
    }

    fn names(log: &StrokeLog) -> Vec<&'static str> {
        log.strokes().iter().map(|stroke| stroke.name).collect()
    }

    #[test]
    fn names_follow_strokes_undo_and_redo() {
        let mut log = StrokeLog::default();
        for (name, count) in [("press", 1), ("pull", 2), ("knife", 3)] {
            log.begin(name);
            assert!(log.update(edits(count, 0), 0, 1.0));
        }
        assert!(!log.update(edits(3, 0), 0, 2.0));
        assert!(log.update(edits(2, 1), 0, 3.0) && log.update(edits(1, 2), 0, 3.0));
        assert_eq!((names(&log), log.done()), (vec!["press", "pull", "knife"], 1));
        assert!(log.update(edits(2, 1), 0, 4.0));
        assert_eq!(log.done(), 2);
        log.begin("grab");
        log.update(edits(3, 0), 0, 5.0);
        assert_eq!((names(&log), log.done()), (vec!["press", "pull", "grab"], 3));
        // Two strokes of the session that belong to one of the pointer are taken back and made again together.
        log.begin("mirrored");
        log.update(edits(5, 0), 0, 5.5);
        assert_eq!((log.count_before(), log.count_after()), (3, 5));
        log.update(edits(3, 2), 0, 5.6);
        assert_eq!((log.count_before(), log.count_after()), (2, 5));
        // A stroke under way counts, and no longer if it has changed nothing.
        log.begin("touch");
        log.update(edits(4, 0), 0, 6.0);
        log.update(edits(3, 0), 0, 7.0);
        assert_eq!((names(&log), log.done()), (vec!["press", "pull", "grab"], 3));
    }

    #[test]
    fn a_stroke_under_way_is_there_and_has_not_ended() {
        let mut log = StrokeLog::default();
        log.begin("press");
        log.update(edits(1, 0), 0, 1.0);
        assert_eq!((log.done(), log.ended(true), log.ended(false)), (1, 0, 1));
        // Of several edits, and with a change of the stiffness while they go on.
        log.begin("cut");
        log.update(edits(3, 0), 0, 2.0);
        log.change_stiffness("stiffness", [1.0, 2.0], 2.5);
        assert_eq!((log.done(), log.ended(true), log.ended(false)), (4, 2, 4));
        log.begin("press");
        assert_eq!((log.done(), log.ended(true)), (4, 4), "it has changed nothing yet");
    }

    /// The session of a full history drops its oldest edit for each new one, so its counts stay as they are.
    #[test]
    fn the_oldest_stroke_of_a_full_history_goes_and_the_newest_stays() {
        let mut log = StrokeLog::default();
        for (name, count) in [("press", 1), ("pull", 2)] {
            log.begin(name);
            log.update(edits(count, 0), 0, 1.0);
        }
        let saved = log.shape();
        // A stroke that ends between two calls, then one that is seen while it is under way.
        log.begin("grab");
        assert!(log.update(edits(2, 0), 1, 2.0));
        assert_eq!((names(&log), log.done()), (vec!["pull", "grab"], 2));
        assert_ne!(log.shape(), saved);
        log.begin("cut");
        assert!(log.update(edits(3, 0), 1, 3.0) && log.update(edits(2, 0), 2, 4.0));
        assert_eq!((names(&log), log.done()), (vec!["grab", "cut"], 2));
        // All that is left is taken back: the saved shape was the one after the second stroke, which is among those that are forgotten.
        log.update(edits(0, 2), 2, 5.0);
        assert_eq!((log.done(), log.shape()), (0, saved));
    }

    #[test]
    fn a_shape_is_known_again_after_undo_and_redo_but_not_by_the_number_of_strokes() {
        let mut log = StrokeLog::default();
        log.begin("press");
        log.update(edits(1, 0), 0, 1.0);
        let pressed = log.shape();
        log.change_stiffness("stiffness", [1.0, 2.0], 1.5);
        assert_eq!(log.shape(), pressed, "stiffness is no shape");
        let go_to = |log: &mut StrokeLog, count| while log.step_to(count).is_some() {};
        go_to(&mut log, 0);
        assert_eq!(log.shape(), 0);
        go_to(&mut log, 2);
        assert_eq!(log.shape(), pressed);
        go_to(&mut log, 0);
        log.update(edits(0, 1), 0, 4.0);
        log.begin("pull");
        log.update(edits(1, 0), 0, 5.0);
        assert_ne!(log.shape(), pressed);
    }

    /// Does what a session would do for the steps towards `count` entries: counts of edits, and the stiffness.
    fn go_to(log: &mut StrokeLog, session: &mut [usize; 2], stiffness: &mut f64, count: usize) {
        while let Some(step) = log.step_to(count) {
            match step {
                HistoryStep::Undo => *session = [session[0] - 1, session[1] + 1],
                HistoryStep::Redo => *session = [session[0] + 1, session[1] - 1],
                HistoryStep::Stiffness(factor) => *stiffness = factor,
            }
        }
        assert!(!log.update(edits(session[0], session[1]), 0, 99.0), "the log knew it");
    }

    /// Random strokes, changes of the stiffness, undo and redo, beside a plain list of states.
    #[test]
    fn strokes_and_stiffness_are_taken_back_in_the_order_in_which_they_came() {
        let mut seed = 7_u64;
        let mut random = move |bound: u64| {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 33) % bound
        };
        let (mut log, mut session, mut stiffness) = (StrokeLog::default(), [0, 0], 1.0);
        // Edits and stiffness after each entry.
        let mut states = vec![([0_usize, 0], 1.0)];
        for round in 0..2000 {
            match random(4) {
                0 => {
                    log.begin("press");
                    session = [session[0] + 1, 0];
                    assert!(log.update(edits(session[0], 0), 0, f64::from(round)));
                    states.truncate(log.done());
                    states.push((session, stiffness));
                }
                1 => {
                    let wanted = 1.0 + random(5) as f64;
                    let is_changed = wanted != stiffness;
                    let last = log.done().checked_sub(1).and_then(|last| log.strokes()[last].stiffness);
                    let (is_joined, is_back) = (last.is_some(), last.is_some_and(|[first, _]| first == wanted));
                    log.change_stiffness("stiffness", [stiffness, wanted], f64::from(round));
                    stiffness = wanted;
                    if is_changed {
                        let kept = log.done() + usize::from(is_back);
                        assert!(is_joined || !is_back);
                        states.truncate(kept);
                        if !is_back {
                            states.push((session, stiffness));
                        }
                    }
                }
                _ => {
                    let count = random(log.strokes().len() as u64 + 1) as usize;
                    go_to(&mut log, &mut session, &mut stiffness, count);
                    assert_eq!(log.done(), count);
                }
            }
            let (edits, factor) = states[log.done()];
            assert_eq!((log.edits(), stiffness), (edits[0], factor), "round {round}");
            assert_eq!(session[0], log.edits());
        }
    }
}
