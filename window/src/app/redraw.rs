//! When the next picture is drawn where nothing asks for one: a window in which nothing changes draws nothing.

use super::App;
use super::gauges::PLOTTED;
use super::viewport::shown_for;
use std::time::Duration;

/// Time between two pictures while gauges and the plot of the force move on.
const GAUGE_PERIOD: Duration = Duration::from_millis(500);
/// Time after which gauges and plot stand still once the model is at rest, s: the plot has become empty, and gauges have been taken over twice.
const SETTLING: f64 = PLOTTED + 1.0;

impl App {
    /// Asks for the next picture of a frame at `time` (s): of gauges and plot while the model moves and shortly after, and of messages when one goes away.
    pub(super) fn schedule_redraw(&mut self, time: f64) {
        self.rest_since = self.status.is_at_rest.then(|| self.rest_since.unwrap_or(time));
        let is_settled = self.rest_since.is_some_and(|since| time - since > SETTLING);
        let gauges = (self.model.is_some() && !is_settled).then_some(GAUGE_PERIOD);
        let left = |(when, text): &(std::time::Instant, String)| shown_for(text).checked_sub(when.elapsed());
        let messages = self.messages.iter().filter_map(left).min();
        if let Some(period) = gauges.into_iter().chain(messages).min() {
            self.context.request_repaint_after(period);
        }
    }
}
