//! Bounded queues from one task to another, whose operations can't panic.
//!
//! The ends of a `heapless` queue know its length only at run time, so that the compiler keeps a division by zero for a
//! queue of no places. There is none, and these ends are written so that the compiler sees it.

use heapless::spsc;

/// Room for N - 1 items.
pub struct Queue<T, const N: usize>(spsc::Queue<T, N>);

impl<T, const N: usize> Queue<T, N> {
    /// An empty one.
    pub const fn new() -> Self {
        Self(spsc::Queue::new())
    }

    /// Its two ends, for two tasks.
    pub fn split(&mut self) -> (Producer<'_, T>, Consumer<'_, T>) {
        let (producer, consumer) = self.0.split();
        (Producer(producer), Consumer(consumer))
    }
}

/// The end where items go in.
pub struct Producer<'a, T>(spsc::Producer<'a, T>);

impl<T> Producer<'_, T> {
    /// Gives the item back if there is no room.
    pub fn enqueue(&mut self, item: T) -> Result<(), T> {
        if has_no_places(self.0.capacity()) { Err(item) } else { self.0.enqueue(item) }
    }
}

/// The end where items come out.
pub struct Consumer<'a, T>(spsc::Consumer<'a, T>);

impl<T> Consumer<'_, T> {
    /// Is there an item?
    pub fn is_ready(&self) -> bool {
        self.0.ready()
    }

    /// The oldest item.
    pub fn dequeue(&mut self) -> Option<T> {
        if has_no_places(self.0.capacity()) { None } else { self.0.dequeue() }
    }
}

/// A queue's capacity is one less than its places.
fn has_no_places(capacity: usize) -> bool {
    capacity == usize::MAX
}
