//! The inputs of the next call, the answer of the last call, and the scenes.

use std::cell::RefCell;

use crate::clips::Clips;
use crate::controllers::Controllers;
use crate::failure::Failure;
use crate::request::{self, Answer};
use crate::robot_streams::RobotStreams;
use crate::scenes::Scenes;

thread_local! {
    /// WebAssembly without threads has a single state.
    static STATE: RefCell<State> = RefCell::new(State::default());
}

/// The state between calls.
#[derive(Default)]
pub(crate) struct State {
    pub(crate) scenes: Scenes,
    pub(crate) clips: Clips,
    pub(crate) controllers: Controllers,
    pub(crate) robot_streams: RobotStreams,
    inputs: Vec<Vec<u8>>,
    json: Vec<u8>,
    bytes: Vec<u8>,
}

/// Returns `None` for a nested call, which JavaScript cannot make.
pub(crate) fn with_state<T>(run: impl FnOnce(&mut State) -> T) -> Option<T> {
    STATE.with(|state| state.try_borrow_mut().ok().map(|mut state| run(&mut state)))
}

impl State {
    pub(crate) fn input(&mut self, length: usize) -> *mut u8 {
        let mut room = Vec::new();
        if room.try_reserve_exact(length).is_err() {
            self.inputs.clear();
            return std::ptr::null_mut();
        }
        room.resize(length, 0);
        self.inputs.push(room);
        self.inputs.last_mut().map_or(std::ptr::null_mut(), Vec::as_mut_ptr)
    }

    /// Returns whether the call succeeded.
    pub(crate) fn call(&mut self) -> bool {
        self.call_with(request::answer)
    }

    /// Executes a request that the drop page never makes. Returns whether the call succeeded.
    pub(crate) fn call_other(&mut self) -> bool {
        self.call_with(request::answer_other)
    }

    fn call_with(&mut self, answer: impl Fn(&mut Self, &[u8], &[Vec<u8>]) -> Result<Answer, Failure>) -> bool {
        let mut inputs = std::mem::take(&mut self.inputs);
        self.bytes = Vec::new();
        let result = match inputs.is_empty() {
            true => Err(Failure::argument("there is no request")),
            false => {
                let request = inputs.remove(0);
                answer(self, &request, &inputs)
            }
        };
        let done = result.is_ok();
        let (json, bytes) = result.unwrap_or_else(|failure| (failure.to_json(), Vec::new()));
        self.json = json;
        self.bytes = bytes;
        done
    }

    pub(crate) fn output(&self, part: u32) -> &[u8] {
        match part {
            0 => &self.json,
            _ => &self.bytes,
        }
    }
}
