# What reads .ptet files; the rest of this folder is the builder's. Also for tools/web, a project of its own.
set(ptet_format_run_time input_order layout numbers reader reader_opening record_runs schema source)
