//! An instance and the modes that FMI leads it through: what may be called when, and on which variables.
//!
//! ```text
//! instantiated --> initialisation --> stepping                          (co-simulation)
//!                               '--> event <--> continuous time         (model exchange)
//! ```

use crate::behaviour::{Refusal, Stop};
use crate::component::{Component, Content};
use crate::variable::{Causality, Value, Variability};
use crate::vehicle::Vehicle;

/// How it is simulated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Interface {
    ModelExchange,
    CoSimulation,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Mode {
    Instantiated,
    Initialisation,
    Stepping,
    Event,
    ContinuousTime,
    Terminated,
}

impl Mode {
    fn name(self) -> &'static str {
        match self {
            Self::Instantiated => "before initialisation mode",
            Self::Initialisation => "in initialisation mode",
            Self::Stepping => "in step mode",
            Self::Event => "in event mode",
            Self::ContinuousTime => "in continuous-time mode",
            Self::Terminated => "after it has ended",
        }
    }
}

/// One simulated thing.
#[derive(Clone)]
pub(crate) struct Instance {
    /// As it was instantiated, for a reset.
    fresh: Component,
    component: Component,
    content: Content,
    interface: Interface,
    mode: Mode,
    time_s: f64,
}

/// What an instance was at a time.
#[derive(Clone)]
pub(crate) struct Saved {
    component: Component,
    mode: Mode,
    time_s: f64,
}

impl Instance {
    pub(crate) fn new(component: Component, content: Content, interface: Interface) -> Result<Self, Refusal> {
        if interface == Interface::ModelExchange && !content.is_for_model_exchange() {
            return Err(format!("a {} is for co-simulation only", content.name()));
        }
        let mode = Mode::Instantiated;
        Ok(Self { fresh: component.clone(), component, content, interface, mode, time_s: 0.0 })
    }

    fn expect(&self, modes: &[Mode], what: &str) -> Result<(), Refusal> {
        if modes.contains(&self.mode) { Ok(()) } else { Err(format!("{what} {}", self.mode.name())) }
    }

    pub(crate) fn enter_initialisation(&mut self, start_s: f64) -> Result<(), Refusal> {
        self.expect(&[Mode::Instantiated], "fmi3EnterInitializationMode")?;
        self.component.behaviour().start_at(start_s)?;
        (self.mode, self.time_s) = (Mode::Initialisation, start_s);
        Ok(())
    }

    pub(crate) fn exit_initialisation(&mut self) -> Result<(), Refusal> {
        self.expect(&[Mode::Initialisation], "fmi3ExitInitializationMode")?;
        self.component.behaviour().prepare()?;
        self.mode = match self.interface {
            Interface::ModelExchange => Mode::Event,
            Interface::CoSimulation => Mode::Stepping,
        };
        Ok(())
    }

    pub(crate) fn enter_event_mode(&mut self) -> Result<(), Refusal> {
        self.expect(&[Mode::ContinuousTime], "fmi3EnterEventMode")?;
        self.mode = Mode::Event;
        Ok(())
    }

    pub(crate) fn enter_continuous_time(&mut self) -> Result<(), Refusal> {
        self.expect(&[Mode::Event], "fmi3EnterContinuousTimeMode")?;
        self.mode = Mode::ContinuousTime;
        Ok(())
    }

    pub(crate) fn terminate(&mut self) -> Result<(), Refusal> {
        self.expect(&[Mode::Stepping, Mode::Event, Mode::ContinuousTime], "fmi3Terminate")?;
        self.mode = Mode::Terminated;
        Ok(())
    }

    pub(crate) fn reset(&mut self) {
        (self.component, self.mode, self.time_s) = (self.fresh.clone(), Mode::Instantiated, 0.0);
    }

    pub(crate) fn save(&self) -> Saved {
        Saved { component: self.component.clone(), mode: self.mode, time_s: self.time_s }
    }

    pub(crate) fn restore(&mut self, saved: &Saved) {
        let Saved { component, mode, time_s } = saved.clone();
        (self.component, self.mode, self.time_s) = (component, mode, time_s);
    }

    /// A variable's place in the list.
    fn place(&self, reference: u32) -> Result<usize, Refusal> {
        let places = self.component.variables.len();
        let place = (reference as usize).checked_sub(1).filter(|place| *place < places);
        place.ok_or_else(|| format!("there is no variable with the value reference {reference}"))
    }

    /// A variable's value; time has the reference 0.
    pub(crate) fn get(&mut self, reference: u32) -> Result<Value, Refusal> {
        if reference == 0 {
            return Ok(Value::Float(self.time_s));
        }
        let place = self.place(reference)?;
        self.component.behaviour().get(place).map_err(|refusal| self.about(place, &refusal))
    }

    pub(crate) fn set(&mut self, reference: u32, value: Value) -> Result<(), Refusal> {
        let place = self.place(reference)?;
        let variable = &self.component.variables[place];
        let before = [Mode::Instantiated, Mode::Initialisation].contains(&self.mode);
        let may_be_set = match (variable.causality, variable.variability) {
            (Causality::Input, Variability::Continuous) => self.mode != Mode::Terminated,
            (Causality::Input, _) => before || [Mode::Event, Mode::Stepping].contains(&self.mode),
            _ => before && variable.has_start(),
        };
        if !may_be_set {
            return Err(self.about(place, &format!("can't be set {}", self.mode.name())));
        }
        self.component.behaviour().set(place, value).map_err(|refusal| self.about(place, &refusal))
    }

    fn about(&self, place: usize, refusal: &str) -> Refusal {
        format!("{}: {refusal}", self.component.variables[place].name)
    }

    pub(crate) fn step(&mut self, from_s: f64, duration_s: f64) -> Result<f64, Refusal> {
        self.expect(&[Mode::Stepping], "fmi3DoStep")?;
        self.component.behaviour().step(from_s, duration_s)?;
        self.time_s = from_s + duration_s;
        Ok(self.time_s)
    }

    /// The part that a foreign integrator integrates.
    pub(crate) fn continuous(&mut self, what: &str) -> Result<&mut Vehicle, Refusal> {
        if self.interface != Interface::ModelExchange {
            return Err(format!("{what}: the instance is for co-simulation"));
        }
        let content = self.content;
        self.component.continuous().ok_or_else(|| format!("{what}: a {} has no continuous states", content.name()))
    }

    pub(crate) fn set_time(&mut self, time_s: f64) -> Result<(), Refusal> {
        self.expect(&[Mode::Event, Mode::ContinuousTime], "fmi3SetTime")?;
        if !time_s.is_finite() {
            return Err(format!("fmi3SetTime: {time_s} s"));
        }
        self.time_s = time_s;
        self.continuous("fmi3SetTime")?.set_time_s(time_s)
    }

    pub(crate) fn set_states(&mut self, states: &[f64]) -> Result<(), Refusal> {
        self.expect(&[Mode::ContinuousTime], "fmi3SetContinuousStates")?;
        self.continuous("fmi3SetContinuousStates")?.set_states(states)
    }

    pub(crate) fn stop(&mut self) -> Result<Stop, Refusal> {
        self.expect(&[Mode::Event], "fmi3UpdateDiscreteStates")?;
        self.continuous("fmi3UpdateDiscreteStates")?.stop()
    }
}
