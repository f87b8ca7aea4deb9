//! Arrays between guards: values before the first and behind the last, by which the suite finds what a plugin reads and writes outside of an array.

use super::protected_memory::{Edge, ProtectedMemory};
use crate::abi::{Output, Pose};
use std::ops::Range;
use std::sync::Mutex;

/// Least number of guards before an array, and behind it.
const GUARDS: usize = 16;

/// A value of an array of the interface, as bits.
pub(super) trait Value: Copy {
    /// Bits of the value's components.
    fn bits(self) -> impl Iterator<Item = u64>;
    /// The value with all components equal to a number.
    fn of(number: f64) -> Self;
}

impl Value for f64 {
    fn bits(self) -> impl Iterator<Item = u64> {
        std::iter::once(self.to_bits())
    }

    fn of(number: f64) -> Self {
        number
    }
}

impl Value for f32 {
    fn bits(self) -> impl Iterator<Item = u64> {
        std::iter::once(u64::from(self.to_bits()))
    }

    fn of(number: f64) -> Self {
        number as f32
    }
}

impl Value for u32 {
    fn bits(self) -> impl Iterator<Item = u64> {
        std::iter::once(u64::from(self))
    }

    fn of(number: f64) -> Self {
        number as u32
    }
}

impl Value for u8 {
    fn bits(self) -> impl Iterator<Item = u64> {
        std::iter::once(u64::from(self))
    }

    fn of(number: f64) -> Self {
        number as u8
    }
}

impl Value for u64 {
    fn bits(self) -> impl Iterator<Item = u64> {
        std::iter::once(self)
    }

    fn of(number: f64) -> Self {
        number as u64
    }
}

impl Value for Pose {
    fn bits(self) -> impl Iterator<Item = u64> {
        let Self { size, time_ns, flags, buttons, position, orientation, velocity } = self;
        let whole = [size as u64, time_ns, u64::from(flags), u64::from(buttons)].into_iter();
        whole.chain(position.bits()).chain(orientation.bits()).chain(velocity.bits())
    }

    fn of(number: f64) -> Self {
        Self { position: [number; 3], ..Self::default() }
    }
}

impl Value for Output {
    fn bits(self) -> impl Iterator<Item = u64> {
        let Self { size, force, torque, taxels, valid_until_ns } = self;
        [size as u64, taxels.addr() as u64, valid_until_ns].into_iter().chain(force.bits()).chain(torque.bits())
    }

    fn of(number: f64) -> Self {
        let (size, taxels) = (size_of::<Self>(), std::ptr::null());
        Self { size, force: [number; 3], torque: [0.0; 3], taxels, valid_until_ns: 0 }
    }
}

impl<T: Value, const K: usize> Value for [T; K] {
    fn bits(self) -> impl Iterator<Item = u64> {
        self.into_iter().flat_map(T::bits)
    }

    fn of(number: f64) -> Self {
        [T::of(number); K]
    }
}

/// An array that a plugin is given, between guards.
#[derive(Clone, Debug)]
pub(super) struct Guarded<T> {
    /// Number of guards before the array, and behind it.
    guards: usize,
    /// Guards, the array, guards.
    values: Vec<T>,
    /// `values` as they were made.
    before: Vec<T>,
    /// The array at a guard page, which is handed over in the place of the one between guards.
    at_page: Option<*mut T>,
}

impl<T: Value> Guarded<T> {
    /// A copy of an array, with guards of a number.
    pub(super) fn new(array: &[T], guard: f64) -> Self {
        Self::with_plane(array, guard, 0)
    }

    /// A copy of planes of `plane` values each, with a whole plane of guards or more.
    pub(super) fn with_plane(array: &[T], guard: f64, plane: usize) -> Self {
        let guards = vec![T::of(guard); plane.max(GUARDS)];
        let values = [&guards, array, &guards].concat();
        Self { guards: guards.len(), before: values.clone(), values, at_page: None }
    }

    /// Hands over a copy of the array at the edge of `memory` from now on, until another array is moved there. Returns whether there is such an array.
    pub(super) fn move_to(&mut self, memory: ProtectedMemory, edge: Edge) -> bool {
        self.at_page = if self.len() == 0 { None } else { memory.place(self.array(), edge) };
        self.at_page.is_some()
    }

    /// Gives the guard at an offset another number. `offset` counts from the first value of the array.
    pub(super) fn set_guard(&mut self, offset: isize, number: f64) {
        let at = usize::try_from(offset + self.guards as isize).expect("a guard");
        (self.values[at], self.before[at]) = (T::of(number), T::of(number));
    }

    /// Offsets of all guards, counted from the first value of the array.
    pub(super) fn guard_offsets(&self) -> impl Iterator<Item = isize> + use<T> {
        let (guards, len) = (self.guards as isize, self.len() as isize);
        (-guards..0).chain(len..len + guards)
    }

    /// Number of values without the guards.
    pub(super) fn len(&self) -> usize {
        self.values.len() - 2 * self.guards
    }

    /// Place of the array among the values.
    fn range(&self) -> Range<usize> {
        self.guards..self.values.len() - self.guards
    }

    /// The values that are handed over, without the guards.
    pub(super) fn array(&self) -> &[T] {
        match self.at_page {
            #[allow(unsafe_code, reason = "the array is in memory of the host")]
            // SAFETY: as many values were copied there, and no other array is there while this one is called with.
            Some(at) => unsafe { std::slice::from_raw_parts(at, self.len()) },
            None => &self.values[self.range()],
        }
    }

    /// As [`Guarded::array`].
    pub(super) fn array_mut(&mut self) -> &mut [T] {
        let (range, len) = (self.range(), self.len());
        match self.at_page {
            #[allow(unsafe_code, reason = "the array is in memory of the host")]
            // SAFETY: as in `array`.
            Some(at) => unsafe { std::slice::from_raw_parts_mut(at, len) },
            None => &mut self.values[range],
        }
    }

    /// Pointer to the first value; null for an array without values.
    pub(super) fn as_ptr(&self) -> *const T {
        // Of the whole, so that a plugin that goes outside of the array meets a guard.
        let guarded =
            || if self.len() == 0 { std::ptr::null() } else { self.values.as_ptr().wrapping_add(self.guards) };
        self.at_page.map_or_else(guarded, <*mut T>::cast_const)
    }

    /// As [`Guarded::as_ptr`], for an array that the plugin writes.
    pub(super) fn as_mut_ptr(&mut self) -> *mut T {
        if self.len() == 0 { std::ptr::null_mut() } else { self.values.as_mut_ptr().wrapping_add(self.guards) }
    }

    /// Offset of the first value that was changed since the array was made, of the guards and of those of the array that `may_change` does not name; counted from
    /// the first value of the array.
    pub(super) fn first_change(&self, may_change: impl Fn(usize) -> bool) -> Option<isize> {
        let (range, len) = (self.range(), self.len());
        let is_changed = |at: &usize| {
            let is_own = range.contains(at) && may_change(at - self.guards);
            !is_own && !self.values[*at].bits().eq(self.before[*at].bits())
        };
        // Guards first: what lies around an array is another's.
        let guards = (self.guards + len..self.values.len()).chain((0..self.guards).rev());
        guards.chain(range.clone()).find(is_changed).map(|at| at as isize - self.guards as isize)
    }
}

/// The guards around the arrays of all calls of a plugin, and the first write that is not into an output.
#[derive(Default)]
pub(super) struct Guards {
    /// An array whose guards have another number.
    changed: Option<(&'static str, f64)>,
    /// The first write into an input or around an array, as a sentence.
    written: Mutex<Option<String>>,
}

impl Guards {
    /// The guards of `array` have a number from now on, and those of others their own.
    pub(super) fn change(&mut self, array: &'static str, number: f64) {
        self.changed = Some((array, number));
    }

    /// A copy of an array between guards.
    pub(super) fn around<T: Value>(&self, name: &str, array: &[T]) -> Guarded<T> {
        Guarded::new(array, self.changed.filter(|(changed, _)| *changed == name).map_or(-0.0, |(_, number)| number))
    }

    /// Looks for writes around what `function` wrote.
    pub(super) fn look_at_output<T: Value>(&self, function: &str, name: &str, array: &Guarded<T>) {
        self.note(function, name, array.first_change(|_| true), array.len());
    }

    /// Looks for writes into and around what `function` read.
    pub(super) fn look_at_input<T: Value>(&self, function: &str, name: &str, array: &Guarded<T>) {
        self.note(function, name, array.first_change(|_| false), array.len());
    }

    /// Keeps the first write.
    fn note(&self, function: &str, name: &str, offset: Option<isize>, len: usize) {
        let Some(offset) = offset else { return };
        let mut written = self.written.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        let place = describe_offset(offset, len);
        written.get_or_insert_with(|| format!("`{function}` wrote to `{name}`: the value {place} was changed"));
    }

    /// The first write into an input or around an array, as a sentence.
    pub(super) fn first_write(&self) -> Option<String> {
        self.written.lock().unwrap_or_else(|poisoned| poisoned.into_inner()).clone()
    }
}

/// Where an offset lies, seen from an array of `len` values.
pub(super) fn describe_offset(offset: isize, len: usize) -> String {
    let behind = offset - len as isize;
    match offset {
        ..0 => format!("{} before its first", -offset),
        _ if behind >= 0 => format!("{} behind its last", behind + 1),
        _ => format!("number {offset}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn changes_of_guards_and_of_values_are_found_at_their_offsets() {
        for changed in [-16_isize, -1, 0, 4, 5, 20] {
            let mut array = Guarded::new(&[[1.0_f64, 2.0]; 5], -0.0);
            let inside = (0..5).contains(&changed);
            assert_eq!(array.first_change(|_| false), None);
            array.values[(changed + 16) as usize][1] = if inside { 3.0 } else { 0.0 };
            assert_eq!(array.first_change(|_| false), Some(changed));
            assert_eq!(array.first_change(|_| true), (!inside).then_some(changed));
        }
        assert_eq!(describe_offset(-1, 5), "1 before its first");
        assert_eq!(describe_offset(5, 5), "1 behind its last");
        assert_eq!(describe_offset(4, 5), "number 4");
    }

    #[test]
    fn guards_are_around_the_array() {
        let mut array = Guarded::new(&[7_u32, 8], 3.0);
        assert_eq!(array.guard_offsets().count(), 2 * GUARDS);
        array.guard_offsets().zip(100..).for_each(|(offset, number)| array.set_guard(offset, f64::from(number)));
        assert_eq!((array.array(), array.first_change(|_| false)), (&[7_u32, 8][..], None));
        assert!(Guarded::<f64>::new(&[], 0.0).as_ptr().is_null());
        assert_eq!(Guarded::with_plane(&[0.0; 90], 0.0, 30).guard_offsets().next(), Some(-30));
    }
}
