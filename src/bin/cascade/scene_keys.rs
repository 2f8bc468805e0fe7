//! The keys of a scene as options, made from their declaration.

use clap::builder::{PossibleValue, PossibleValuesParser};
use clap::{Arg, ArgAction, ArgMatches, Args, Command, FromArgMatches};
use wavecascade::chain::scene::{Choice, Kind, Property, Setting, UNSET, properties};

/// The keys that were typed as options.
#[derive(Debug, Clone, Default)]
pub struct SceneKeys {
    pub settings: Vec<Setting>,
}

impl Args for SceneKeys {
    fn augment_args(command: Command) -> Command {
        // Only for the command that is typed: the declaration takes milliseconds to read. A command
        // holds one such function, so other flattened arguments must not use it.
        command.defer(|command| {
            let hidden = !asks_for_keys();
            let options = properties().iter().map(|property| {
                option(property)
                    .hide_short_help(hidden)
                    .hide_long_help(hidden)
            });
            let command = command.args(options);
            match hidden {
                true => {
                    let more = format!(
                        "Every key of a scene is an option, too, such as `--stiffness-ratio 4.9`; `none` unsets one.\n\
                         `cascade {} --help scene` lists them by topic.",
                        command.get_name()
                    );
                    let example = command.get_after_help().map(|text| format!("{text}\n\n"));
                    command.after_help(example.unwrap_or_default() + &more)
                }
                false => command,
            }
        })
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl FromArgMatches for SceneKeys {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let mut settings = Vec::new();
        for property in properties() {
            let typed = matches.get_many::<String>(&property.name);
            settings.extend(typed.into_iter().flatten().map(|text| Setting {
                key: property.name.clone(),
                text: text.clone(),
                source: format!("--{}", kebab(&property.name)),
            }));
        }
        Ok(SceneKeys { settings })
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

/// Whether the command line ends with `--help scene`, which lists the keys of scenes, too: they are ten
/// times as many as a command's own options.
fn asks_for_keys() -> bool {
    let words = crate::words::as_text().into_iter();
    let mut typed = words.skip_while(|text| text != "--help" && text != "-h");
    typed.next().is_some() && typed.next().as_deref() == Some("scene")
}

fn option(property: &'static Property) -> Arg {
    let name = property.name.as_str();
    let mut help = property.description.trim_end_matches('.').to_owned();
    let arg = Arg::new(name)
        .long(kebab(name))
        .help_heading(property.group.as_str())
        .value_name(hint(&property.kind))
        .action(match property.kind {
            Kind::Tables => ArgAction::Append,
            _ => ArgAction::Set,
        });
    let arg = match &property.kind {
        Kind::Choice(choices) => {
            let values = choices.iter().map(|choice: &'static Choice| {
                let value = PossibleValue::new(choice.name.as_str());
                match choice.description.as_str() {
                    "" => value,
                    about => value.help(about.trim_end_matches('.')),
                }
            });
            let has_none = choices.iter().any(|choice| choice.name == UNSET);
            let unset = (!has_none).then(|| PossibleValue::new(UNSET).hide(true));
            arg.value_parser(PossibleValuesParser::new(values.chain(unset)))
        }
        Kind::Choices(choices) => {
            let names: Vec<&str> = choices.iter().map(|choice| choice.name.as_str()).collect();
            help += &format!(": of {}, with commas between", names.join(", "));
            arg.allow_hyphen_values(true)
        }
        // "-9 mm" is no number to the parser of arguments.
        Kind::Numbers | Kind::Tables | Kind::Measure { .. } => arg.allow_hyphen_values(true),
        _ => arg.allow_negative_numbers(true),
    };
    if let Some(default) = &property.default {
        let default = default.to_string();
        let plain = default.trim_matches(['"', '[', ']']).replace('"', "");
        help += &format!(" [default: {plain}]");
    }
    arg.help(help)
}

fn hint(kind: &Kind) -> &'static str {
    match kind {
        Kind::Number => "NUMBER",
        Kind::Whole => "N",
        Kind::Flag => "true|false",
        Kind::Text => "NAME",
        Kind::Measure { .. } => "QUANTITY",
        Kind::Choice(_) => "CHOICE",
        Kind::Numbers => "NUMBERS",
        Kind::Choices(_) => "NAMES",
        Kind::Tables => "TABLE",
    }
}

fn kebab(name: &str) -> String {
    name.replace('_', "-")
}
