mod expression;
mod plant;
