"""Measurements that fill the tables of `docs/`: quality against ray-traced truth. Development only, not shipped."""
