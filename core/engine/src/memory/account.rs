//! The account of a session that is being opened: what its bodies take, within the budget.

use super::budget::MemoryBudget;
use super::estimate::{BodyMemory, PROGRAM_BYTES};
use super::size::format_bytes;

/// Estimates of the bodies so far, and the budget they must keep to.
#[derive(Debug)]
pub(crate) struct MemoryAccount {
    /// The largest allowed sum.
    budget: MemoryBudget,
    /// The bodies, in the order of the scene.
    bodies: Vec<BodyMemory>,
    /// Sum of their estimates, bytes.
    sum: u128,
}

impl MemoryAccount {
    /// An account without bodies.
    pub(crate) fn new(budget: MemoryBudget) -> Self {
        Self { budget, bodies: Vec::new(), sum: 0 }
    }

    /// Adds a body that takes nothing yet.
    pub(crate) fn add_body(&mut self, name: &str) {
        self.bodies.push(BodyMemory { body: name.into(), ..Default::default() });
    }

    /// Changes the estimate of the body `index` of the scene.
    pub(crate) fn update(&mut self, index: usize, change: impl FnOnce(&mut BodyMemory)) {
        let body = &mut self.bodies[index];
        self.sum -= u128::from(body.total());
        change(body);
        self.sum += u128::from(body.total());
    }

    /// Memory of the program and of all bodies so far, bytes.
    pub(crate) fn taken(&self) -> u64 {
        u64::try_from(u128::from(PROGRAM_BYTES) + self.sum).unwrap_or(u64::MAX)
    }

    /// Bytes that are left of the budget.
    pub(crate) fn left(&self) -> u64 {
        self.budget.bytes().saturating_sub(self.taken())
    }

    /// Checks that another `bytes` for `owner` (such as a body, by its name) are within the budget. `what` names what they are for, with its count; `fitting` gives a
    /// smaller setting, if there is one.
    ///
    /// # Errors
    /// The message for people.
    pub(crate) fn check(
        &self,
        owner: &str,
        bytes: u64,
        what: &str,
        fitting: impl FnOnce(u64) -> Option<String>,
    ) -> Result<(), String> {
        let left = self.left();
        if bytes <= left {
            return Ok(());
        }
        let (needed, taken, budget) = (format_bytes(bytes), format_bytes(self.taken()), &self.budget);
        let fitting = fitting(left).map(|text| format!(", or {text}")).unwrap_or_default();
        Err(format!(
            "{owner} needs about {needed} of memory for {what}, and {taken} are taken before it; allowed is {budget}: \
             allow more with `--memory SIZE`{fitting}"
        ))
    }

    /// The estimates of all bodies.
    pub(crate) fn into_bodies(self) -> Vec<BodyMemory> {
        self.bodies
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::memory::estimate::total;

    #[test]
    fn a_body_over_the_budget_is_named_with_what_is_taken_and_what_would_fit() {
        let mut account = MemoryAccount::new(MemoryBudget::new(total(&[]) + 3_000_000));
        account.add_body("left");
        account.update(0, |body| body.model = 2_000_000);
        account.add_body("right");
        assert_eq!(account.taken(), total(&account.bodies));
        let check = |bytes| account.check("body `right`", bytes, "7 cells", |left| Some(format!("use {left} bytes")));
        assert_eq!(check(1_000_000), Ok(()));
        let text = check(1_000_001).unwrap_err();
        for part in ["`right`", "1.0 MB", "7 cells", "26.0 MB", "27.0 MB", "--memory", "or use 1000000 bytes"] {
            assert!(text.contains(part), "`{text}` lacks `{part}`");
        }
    }
}
