//! What was answered lately, so that a repeated request is not carried out twice.

use crate::Reply;

/// Requests that may be on their way at once. A controller's receive buffer holds as many frames of the largest size, so none can be
/// lost there.
pub const WINDOW: usize = 8;

/// The last [`WINDOW`] answers.
#[derive(Clone, Debug)]
pub struct Answered {
    last: [Option<(u16, Reply)>; WINDOW],
    next: usize,
}

impl Answered {
    /// Nothing was answered.
    pub const fn new() -> Self {
        Self {
            last: [None; WINDOW],
            next: 0,
        }
    }

    /// What was answered to the request of this number.
    pub fn find(&self, id: u16) -> Option<Reply> {
        let last = self.last.iter().flatten();
        last.into_iter()
            .find(|(number, _)| *number == id)
            .map(|(_, reply)| *reply)
    }

    /// Takes an answer in place of the oldest.
    pub fn add(&mut self, id: u16, reply: Reply) {
        if let Some(place) = self.last.get_mut(self.next) {
            *place = Some((id, reply));
        }
        self.next = (self.next + 1) % WINDOW;
    }
}

impl Default for Answered {
    fn default() -> Self {
        Self::new()
    }
}
