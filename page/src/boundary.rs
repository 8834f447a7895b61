//! Where JavaScript and Rust meet: three functions out, one in, and nothing but bytes between them, so that neither
//! needs generated code.
//!
//! A call is: `room_for(length)` once for the request and once for each file, each filled by the caller; then
//! `answer()`, which takes them all and gives the length of its answer; then `answer_at()`, where that lies until the
//! next call. On the way `said` is called with JSON: progress, or why it all ended.
#![allow(unsafe_code)] // names without mangling, and the import

use std::cell::RefCell;

use crate::requests;

thread_local! {
    /// The request, then the files, as they come.
    static GIVEN: RefCell<Vec<Vec<u8>>> = const { RefCell::new(Vec::new()) };
    /// The last answer.
    static ANSWER: RefCell<String> = const { RefCell::new(String::new()) };
}

#[cfg(target_family = "wasm")]
#[link(wasm_import_module = "page")]
unsafe extern "C" {
    fn said(text: *const u8, length: usize);
}

/// Gives the page something to show before the answer is there.
#[cfg(target_family = "wasm")]
pub(crate) fn say(text: &str) {
    // SAFETY: the page reads these bytes before it returns, and nothing else
    unsafe { said(text.as_ptr(), text.len()) }
}

/// There is no page.
#[cfg(not(target_family = "wasm"))]
fn say(_text: &str) {}

/// Room for the next bytes of a call; where the caller is to write them.
#[unsafe(no_mangle)]
pub extern "C" fn room_for(length: usize) -> *mut u8 {
    GIVEN.with_borrow_mut(|given| {
        given.push(vec![0; length]);
        given.last_mut().map_or(std::ptr::null_mut(), Vec::as_mut_ptr)
    })
}

/// Answers the call; the length of the answer, in bytes.
#[unsafe(no_mangle)]
pub extern "C" fn answer() -> usize {
    std::panic::set_hook(Box::new(|panic| {
        let failure = serde_json::json!({ "failure": panic.to_string() });
        say(&failure.to_string());
    }));
    let mut given = GIVEN.take().into_iter();
    let request = given.next().unwrap_or_default();
    let text = requests::answer(&request, given.collect(), &|progress| {
        let (done, total, what) = progress.step();
        say(&serde_json::json!({ "done": done, "total": total, "what": what }).to_string());
    });
    ANSWER.replace(text);
    ANSWER.with_borrow(String::len)
}

/// Where the answer lies.
#[unsafe(no_mangle)]
pub extern "C" fn answer_at() -> *const u8 {
    ANSWER.with_borrow(|answer| answer.as_ptr())
}
