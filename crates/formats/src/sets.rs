//! Arrays that are alike form one variable; what is left out of it is said.

use indexmap::IndexMap;

/// What the arrays of one variable have in common: names of properties and their values.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(crate) struct Traits(pub Vec<(&'static str, String)>);

/// Arrays by what they have in common, in the order of the file.
pub(crate) type Sets<T> = IndexMap<Traits, Vec<T>>;

impl Traits {
    /// The first property that differs from that of `other`.
    fn differs(&self, other: &Traits) -> Option<String> {
        let mut pairs = self.0.iter().zip(&other.0);
        let ((name, own), (_, others)) = pairs.find(|(own, others)| own != others)?;
        Some(format!("{name} {own}, not {others}"))
    }
}

/// The only one of these lists that varies, if it rises from one array to the next.
pub(crate) fn only_rising<'a>(lists: impl Iterator<Item = &'a [f64]>) -> Option<usize> {
    let varies = |(_, values): &(usize, &[f64])| values.iter().any(|value| *value != values[0]);
    let mut varying = lists.enumerate().filter(varies);
    let (place, values) = varying.next()?;
    (varying.next().is_none() && values.is_sorted_by(|a, b| a < b)).then_some(place)
}

/// Sets of arrays with their traits.
pub(crate) fn sets<T>(arrays: impl IntoIterator<Item = (Traits, T)>) -> Sets<T> {
    let mut sets = Sets::new();
    for (traits, array) in arrays {
        sets.entry(traits).or_default().push(array);
    }
    sets
}

/// The arrays that are no part of the set `of`, each with the first trait in which it differs.
pub(crate) fn others<T>(
    sets: &Sets<T>,
    of: &Traits,
    name: impl Fn(&T) -> String,
) -> impl Iterator<Item = String> {
    let sets = sets.iter();
    let apart = sets.filter_map(move |(traits, arrays)| Some((traits.differs(of)?, arrays)));
    apart.flat_map(move |(why, arrays)| {
        let named = arrays.iter().map(|one| format!("{} ({why})", name(one)));
        named.collect::<Vec<_>>()
    })
}

/// A variable of arrays that are alike.
pub(crate) struct Alike<T> {
    pub path: String,
    /// What is said of it.
    pub remark: Option<String>,
    pub arrays: Vec<T>,
}

/// The variables of all sets: a single array has the path that `path_of` gives, several have `path`, behind which a
/// number stands where several sets need one. Sets of several arrays have a remark.
pub(crate) fn variables<T>(
    sets: Sets<T>,
    path: &str,
    path_of: impl Fn(&T) -> String,
    remark: impl Fn(&Sets<T>, &Traits) -> Option<String>,
) -> Vec<Alike<T>> {
    let several = sets.values().filter(|arrays| arrays.len() > 1).count();
    let said = |(traits, arrays): (&Traits, &Vec<T>)| {
        let is_several = arrays.len() > 1;
        is_several.then(|| remark(&sets, traits)).flatten()
    };
    let remarks: Vec<Option<String>> = sets.iter().map(said).collect();
    let mut number = 0;
    let variable = |(arrays, remark): (Vec<T>, Option<String>)| {
        let path = match &arrays[..] {
            [only] => path_of(only),
            _ if several == 1 => path.to_owned(),
            _ => {
                number += 1;
                format!("{path}/{number}")
            }
        };
        Alike {
            path,
            remark,
            arrays,
        }
    };
    sets.into_values().zip(remarks).map(variable).collect()
}
